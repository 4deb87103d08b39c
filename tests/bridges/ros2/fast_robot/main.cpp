// A robot on Fast DDS (rmw_fastrtps), another vendor than ours: prints what it reads of a Temperature and a Float64,
// and publishes one of each. Its types are written by hand, from the page.
//
//   fast-robot TEMPERATURE_NAME FLOAT64_NAME
#include <unistd.h>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <string>
#include <thread>
#include <utility>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// A value of either type; the header is that of Temperature.
struct Value {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame{};
  double value = 0;
};

/// Plain CDR, little-endian: 00 01 00 00, then the members, each aligned to its size.
class HandMade final : public fast::TopicDataType {
 public:
  HandMade(const char* name, bool has_header) : has_header_(has_header) {
    setName(name);
    m_typeSize = 512;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& value = *static_cast<const Value*>(data);
    std::uint32_t at = 0;
    const auto put = [&](const void* bytes, std::size_t size) {
      std::memcpy(payload->data + at, bytes, size);
      at += static_cast<std::uint32_t>(size);
    };
    const auto align = [&](std::uint32_t to) {
      while ((at - 4) % to != 0) payload->data[at++] = 0;
    };
    put("\0\1\0\0", 4);
    const double variance = 0;
    if (has_header_) {
      const auto length = static_cast<std::uint32_t>(value.frame.size() + 1);
      put(&value.sec, 4);
      put(&value.nanosec, 4);
      put(&length, 4);
      put(value.frame.c_str(), length);
    }
    align(8);
    put(&value.value, 8);
    if (has_header_) put(&variance, 8);
    payload->length = at;
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    auto& value = *static_cast<Value*>(data);
    std::uint32_t at = 4;
    const auto get = [&](void* into, std::uint32_t size) {
      if (at + size > payload->length) return false;
      std::memcpy(into, payload->data + at, size);
      at += size;
      return true;
    };
    if (has_header_) {
      std::uint32_t length = 0;
      if (!get(&value.sec, 4) || !get(&value.nanosec, 4) || !get(&length, 4) || length == 0 || length > 300)
        return false;
      value.frame.resize(length);
      if (!get(value.frame.data(), length)) return false;
      value.frame.pop_back();
    }
    while ((at - 4) % 8 != 0) ++at;
    return get(&value.value, 8);
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return 512U; };
  }
  void* createData() override { return new Value; }
  void deleteData(void* data) override { delete static_cast<Value*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  bool has_header_;
};

fast::DomainParticipant* join() {
  fast::DomainParticipantQos qos;
  const std::string who = "enclave=/;";
  qos.user_data().data_vec({who.begin(), who.end()});
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = {2, 0};
  discovery.leaseDuration_announcementperiod = {0, 500'000'000};
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  return fast::DomainParticipantFactory::get_instance()->create_participant(0, qos);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 1;
  auto* participant = join();
  if (participant == nullptr) return 2;
  const fast::TypeSupport heat(new HandMade("sensor_msgs::msg::dds_::Temperature_", true));
  const fast::TypeSupport number(new HandMade("std_msgs::msg::dds_::Float64_", false));
  heat.register_type(participant);
  number.register_type(participant);
  auto* subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  auto* publisher = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
  fast::DataReaderQos reading;
  reading.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  fast::DataWriterQos writing;
  writing.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  writing.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  const auto topic = [&](const std::string& name, const fast::TypeSupport& type) {
    return participant->create_topic("rt" + name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  };
  auto* temperature = subscriber->create_datareader(topic(argv[1], heat), reading);
  auto* power = subscriber->create_datareader(topic(argv[2], number), reading);
  auto* heat_of_motor = publisher->create_datawriter(topic("/fast/motor", heat), writing);
  auto* load = publisher->create_datawriter(topic("/fast/load", number), writing);
  const pid_t parent = ::getppid();
  while (::getppid() == parent) {
    Value value;
    fast::SampleInfo info;
    while (temperature->take_next_sample(&value, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) std::printf("temperature %g %s %d\n", value.value, value.frame.c_str(), value.sec);
    }
    while (power->take_next_sample(&value, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) std::printf("power %g\n", value.value);
    }
    std::fflush(stdout);
    Value motor{0, 0, "motor", 61.5}, half{0, 0, {}, 0.5};
    heat_of_motor->write(&motor);
    load->write(&half);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return 0;
}
