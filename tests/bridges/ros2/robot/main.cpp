// A process that does what rmw_cyclonedds does (docs/ros2.md): user data, ros_discovery_info, rmw's QoS. Commands come
// by standard input, one a line; what it sees goes to standard output.
//
//   robot DOMAIN humble|jazzy LEASE_MS
//   echo NAME TYPE [best]    reads as `ros2 topic echo`: with the durability of the publisher; prints `NAME VALUE`
//   late NAME TYPE           the same, and transient-local whatever the publisher is
//   stop NAME
//   raw NAME TYPE BYTES      prints `NAME HEX` of the first BYTES of each payload
//   pub NAME TYPE VALUE      std_msgs only; `hold` keeps it, as a latched topic
//   bytes NAME TYPE HEX      any payload under the name of the type
//   offer NAME TYPE [hold]   a publisher that says nothing yet
//   drop NAME                the publisher goes
//   many COUNT               publishers of so many topics
#include <dds/dds.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "ros_types.h"

namespace {

struct Qos {
  Qos(bool reliable, bool kept, int depth) : qos(dds_create_qos()) {
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_MSECS(100));
    dds_qset_durability(qos, kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
    dds_qset_writer_data_lifecycle(qos, false);
  }
  ~Qos() { dds_delete_qos(qos); }
  Qos(const Qos&) = delete;
  Qos& operator=(const Qos&) = delete;
  dds_qos_t* qos;
};

/// Payloads of a fixed number of octets, whatever they mean.
class RawType {
 public:
  RawType(std::string dds_type, std::uint32_t size) : name_(std::move(dds_type)) {
    ops_ = {std::uint32_t{DDS_OP_ADR} | std::uint32_t{DDS_OP_TYPE_ARR} | std::uint32_t{DDS_OP_SUBTYPE_1BY}, 0, size,
            DDS_OP_RTS};
    descriptor_.reset(new dds_topic_descriptor_t{
        size, 1, DDS_TOPIC_FIXED_SIZE, 0, name_.c_str(), nullptr, 4, ops_.data(), "", {nullptr, 0}, {nullptr, 0}, 0});
  }
  const dds_topic_descriptor_t* get() const { return descriptor_.get(); }

 private:
  std::string name_;
  std::vector<std::uint32_t> ops_;
  std::unique_ptr<const dds_topic_descriptor_t> descriptor_;
};

/// `std_msgs/msg/Bool` -> `std_msgs::msg::dds_::Bool_`
std::string dds_type(const std::string& ros) {
  const auto slash = ros.find('/');
  return ros.substr(0, slash) + "::msg::dds_::" + ros.substr(ros.rfind('/') + 1) + "_";
}

template <class Message>
const Message& as(const void* message) {
  return *static_cast<const Message*>(message);
}

struct Form {
  const dds_topic_descriptor_t* descriptor;
  std::function<std::string(const void*)> text;
};

std::string diagnostics_text(const void* message) {
  const auto& from = as<diagnostic_msgs_msg_dds__DiagnosticArray_>(message);
  std::string out;
  for (std::uint32_t i = 0; i < from.status._length; ++i) {
    const auto& status = from.status._buffer[i];
    out += fmt::format("[{} {} {} {}", status.name, int{status.level}, status.message, status.hardware_id);
    for (std::uint32_t k = 0; k < status.values._length; ++k)
      out += fmt::format("; {}={}", status.values._buffer[k].key, status.values._buffer[k].value);
    out += "]";
  }
  return out;
}

const std::map<std::string, Form>& forms() {
  static const std::map<std::string, Form> kAll{
      {"std_msgs/msg/Bool",
       {&std_msgs_msg_dds__Bool__desc,
        [](const void* m) { return std::string(as<std_msgs_msg_dds__Bool_>(m).data ? "true" : "false"); }}},
      {"std_msgs/msg/Int64",
       {&std_msgs_msg_dds__Int64__desc,
        [](const void* m) { return fmt::to_string(as<std_msgs_msg_dds__Int64_>(m).data); }}},
      {"std_msgs/msg/Float64",
       {&std_msgs_msg_dds__Float64__desc,
        [](const void* m) { return fmt::to_string(as<std_msgs_msg_dds__Float64_>(m).data); }}},
      {"std_msgs/msg/String",
       {&std_msgs_msg_dds__String__desc,
        [](const void* m) { return std::string(as<std_msgs_msg_dds__String_>(m).data); }}},
      {"sensor_msgs/msg/Temperature",
       {&sensor_msgs_msg_dds__Temperature__desc,
        [](const void* m) {
          const auto& from = as<sensor_msgs_msg_dds__Temperature_>(m);
          return fmt::format("{} {}", from.temperature, from.header.frame_id);
        }}},
      {"diagnostic_msgs/msg/DiagnosticArray", {&diagnostic_msgs_msg_dds__DiagnosticArray__desc, diagnostics_text}},
  };
  return kAll;
}

class Robot {
 public:
  Robot(unsigned domain, bool jazzy, unsigned lease) : jazzy_(jazzy) {
    const auto xml = fmt::format(
        "<CycloneDDS xmlns='https://cdds.io/config'><Domain Id='any'><General><Interfaces><NetworkInterface name='lo' "
        "multicast='true'/></Interfaces><AllowMulticast>spdp</AllowMulticast></"
        "General><Discovery><ParticipantIndex>auto"
        "</ParticipantIndex><MaxAutoParticipantIndex>60</MaxAutoParticipantIndex><Peers><Peer address='127.0.0.1'/>"
        "</Peers><LeaseDuration>{} ms</LeaseDuration><SPDPInterval>500 ms</SPDPInterval></Discovery>"
        "<Tracing><Verbosity>none</Verbosity></Tracing></Domain></CycloneDDS>",
        lease);
    dds_set_log_mask(0);
    if (dds_create_domain(domain, xml.c_str()) < 0) std::exit(2);
    const Qos who(true, false, 1);
    dds_qset_userdata(who.qos, "enclave=/;", 10);
    participant_ = dds_create_participant(domain, who.qos, nullptr);
    if (participant_ < 0) std::exit(3);
    const Qos builtin(true, true, 1);
    publications_ = dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
    participants_ = dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr);
    listen_for_nodes(builtin.qos);
    const Qos log(true, true, 1000);
    hash(log.qos);
    const auto topic = dds_create_topic(participant_, rosout_.get(), "rt/rosout", nullptr, nullptr);
    dds_create_writer(participant_, topic, log.qos, nullptr);
  }

  void run() {
    std::string input;
    std::cout << "ready" << std::endl;
    while (true) {
      pollfd in{STDIN_FILENO, POLLIN, 0};
      if (::poll(&in, 1, 1) > 0) {
        char buffer[65536];
        const auto got = ::read(STDIN_FILENO, buffer, sizeof buffer);
        if (got <= 0) return;
        input.append(buffer, static_cast<std::size_t>(got));
        for (auto end = input.find('\n'); end != input.npos; end = input.find('\n')) {
          command(input.substr(0, end));
          input.erase(0, end + 1);
        }
      }
      look();
    }
  }

 private:
  struct Reader {
    dds_entity_t entity = 0;
    std::function<std::string(const void*)> text;
    std::shared_ptr<RawType> raw{};
  };

  void hash(dds_qos_t* qos) const {
    static const std::string kHash = "typehash=RIHS01_" + std::string(64, 'a') + ";";
    if (jazzy_) dds_qset_userdata(qos, kHash.data(), kHash.size());
  }

  /// Misreads a Gid of the other size, as rmw does.
  void listen_for_nodes(const dds_qos_t* qos) {
    const auto& old = rmw_dds_common_msg_dds__humble_ParticipantEntitiesInfo__desc;
    const auto& now = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
    old_ = std::make_unique<dds_topic_descriptor_t>(dds_topic_descriptor_t{
        old.m_size, old.m_align, old.m_flagset, 0, now.m_typename, nullptr, old.m_nops, old.m_ops, "", {}, {}, 0});
    const auto topic =
        dds_create_topic(participant_, jazzy_ ? &now : old_.get(), "ros_discovery_info", nullptr, nullptr);
    nodes_ = dds_create_reader(participant_, topic, qos, nullptr);
  }

  template <class Visit>
  void take(dds_entity_t reader, Visit visit) {
    void* samples[16] = {};
    dds_sample_info_t infos[16];
    for (int count = 1; count > 0;) {
      count = dds_take(reader, samples, infos, 16, 16);
      for (int i = 0; i < count; ++i) visit(samples[i], infos[i]);
      if (count > 0) dds_return_loan(reader, samples, count);
    }
  }

  template <class Message>
  void print_nodes(const void* message) {
    const auto& from = as<Message>(message);
    for (std::uint32_t i = 0; i < from.node_entities_info_seq._length; ++i) {
      const auto& node = from.node_entities_info_seq._buffer[i];
      fmt::print("node {} {} readers {} writers {}\n", node.node_namespace, node.node_name, node.reader_gid_seq._length,
                 node.writer_gid_seq._length);
    }
  }

  void look() {
    take(participants_, [](const void* sample, const dds_sample_info_t& info) {
      void* bytes = nullptr;
      std::size_t size = 0;
      const auto& from = as<dds_builtintopic_participant_t>(sample);
      if (!info.valid_data || !dds_qget_userdata(from.qos, &bytes, &size) || size == 0) return;
      fmt::print("participant {}\n", std::string(static_cast<const char*>(bytes), size));
      dds_free(bytes);
    });
    take(publications_, [this](const void* sample, const dds_sample_info_t& info) {
      const auto& from = as<dds_builtintopic_endpoint_t>(sample);
      const std::string key(reinterpret_cast<const char*>(from.key.v), sizeof from.key.v);
      if (!info.valid_data) fmt::print("gone {}\n", names_[key]);
      if (!info.valid_data) return;
      names_[key] = from.topic_name;
      dds_durability_kind_t durability{};
      dds_qget_durability(from.qos, &durability);
      kept_[from.topic_name] = durability >= DDS_DURABILITY_TRANSIENT_LOCAL;
      fmt::print("topic {} {} {}\n", from.topic_name, from.type_name, kept_[from.topic_name] ? "kept" : "volatile");
    });
    take(nodes_, [this](const void* sample, const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      if (jazzy_)
        print_nodes<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(sample);
      else
        print_nodes<rmw_dds_common_msg_dds__humble_ParticipantEntitiesInfo_>(sample);
    });
    for (const auto& [name, reader] : readers_) {
      take(reader.entity, [&, key = name](const void* sample, const dds_sample_info_t& info) {
        if (info.valid_data) fmt::print("{} {}\n", key, reader.text(sample));
      });
    }
    std::fflush(stdout);
  }

  void command(const std::string& line) {
    std::istringstream words(line);
    std::string verb, name, type, rest;
    words >> verb >> name >> type;
    std::getline(words >> std::ws, rest);
    const auto topic = "rt" + name;
    if (verb == "echo" || verb == "late") {
      const Qos qos(rest != "best", verb == "late" || kept_[topic], 10);
      hash(qos.qos);
      const auto& form = forms().at(type);
      const auto made = dds_create_topic(participant_, form.descriptor, topic.c_str(), nullptr, nullptr);
      readers_[name] = {dds_create_reader(participant_, made, qos.qos, nullptr), form.text};
    } else if (verb == "raw") {
      const auto size = static_cast<std::uint32_t>(std::stoul(rest));
      auto raw = std::make_shared<RawType>(dds_type(type), size);
      const Qos qos(true, kept_[topic], 10);
      const auto made = dds_create_topic(participant_, raw->get(), topic.c_str(), nullptr, nullptr);
      const auto text = [size](const void* bytes) {
        std::string out;
        for (std::uint32_t i = 0; i < size; ++i)
          out += fmt::format("{:02x}", static_cast<const std::uint8_t*>(bytes)[i]);
        return out;
      };
      readers_[name] = {dds_create_reader(participant_, made, qos.qos, nullptr), text, raw};
    } else if (verb == "stop") {
      dds_delete(std::exchange(readers_[name], {}).entity);
      readers_.erase(name);
    } else if (verb == "drop") {
      dds_delete(writers_[name]);
      writers_.erase(name);
    } else if (verb == "offer") {
      offer(name, forms().at(type).descriptor, rest == "hold");
    } else if (verb == "many") {
      const Qos qos(true, false, 1);
      const auto publisher = dds_create_publisher(participant_, nullptr, nullptr);
      for (int i = 0; i < std::stoi(name); ++i) {
        const auto made = dds_create_topic(participant_, &std_msgs_msg_dds__Float64__desc,
                                           fmt::format("rt/many/topic_{}", i).c_str(), nullptr, nullptr);
        dds_create_writer(publisher, made, qos.qos, nullptr);
      }
    } else if (verb == "pub") {
      publish(name, type, rest);
    } else if (verb == "bytes") {
      publish_bytes(name, type, rest);
    }
    fmt::print("did {}\n", line.substr(0, 60));
  }

  dds_entity_t offer(const std::string& name, const dds_topic_descriptor_t* descriptor, bool kept) {
    auto& entity = writers_[name];
    if (entity > 0) return entity;
    const Qos qos(true, kept, kept ? 1 : 10);
    hash(qos.qos);
    const auto topic = dds_create_topic(participant_, descriptor, ("rt" + name).c_str(), nullptr, nullptr);
    return entity = dds_create_writer(participant_, topic, qos.qos, nullptr);
  }

  /// Nothing tells a writer when the other side has matched.
  static constexpr dds_duration_t kTheirMatch = DDS_MSECS(300);

  dds_entity_t writer(const std::string& name, const dds_topic_descriptor_t* descriptor, bool kept) {
    const bool known = writers_[name] > 0;
    const auto entity = offer(name, descriptor, kept);
    // As one does with `ros2 topic pub --once`: waits for the other side, which learns of this one a moment later.
    dds_publication_matched_status_t matched{};
    for (int i = 0; i < 60'000 && matched.current_count == 0; ++i, dds_sleepfor(DDS_MSECS(1)))
      dds_get_publication_matched_status(entity, &matched);
    if (!known) dds_sleepfor(kTheirMatch);
    return entity;
  }

  void publish(const std::string& name, const std::string& type, std::string value) {
    const bool kept = value.starts_with("hold ");
    if (kept) value.erase(0, 5);
    const auto entity = writer(name, forms().at(type).descriptor, kept);
    if (type == "std_msgs/msg/Bool") {
      const std_msgs_msg_dds__Bool_ message{value == "true"};
      dds_write(entity, &message);
    } else if (type == "std_msgs/msg/Int64") {
      const std_msgs_msg_dds__Int64_ message{std::stoll(value)};
      dds_write(entity, &message);
    } else if (type == "std_msgs/msg/Float64") {
      const std_msgs_msg_dds__Float64_ message{std::stod(value)};
      dds_write(entity, &message);
    } else {
      const std_msgs_msg_dds__String_ message{value.data()};
      dds_write(entity, &message);
    }
  }

  void publish_bytes(const std::string& name, const std::string& type, const std::string& hex) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
      bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
    raws_.push_back(std::make_unique<RawType>(dds_type(type), static_cast<std::uint32_t>(bytes.size())));
    const auto entity = writer(name, raws_.back()->get(), false);
    dds_write(entity, bytes.data());
  }

  bool jazzy_;
  RawType rosout_{"rcl_interfaces::msg::dds_::Log_", 4};
  dds_entity_t participant_ = 0, publications_ = 0, participants_ = 0, nodes_ = 0;
  std::unique_ptr<dds_topic_descriptor_t> old_;
  std::map<std::string, bool> kept_;
  std::map<std::string, std::string> names_;  ///< of topics, by the GUID of the publisher
  std::map<std::string, Reader> readers_;
  std::map<std::string, dds_entity_t> writers_;
  std::vector<std::unique_ptr<RawType>> raws_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 1;
  Robot(static_cast<unsigned>(std::stoul(argv[1])), std::string(argv[2]) == "jazzy",
        static_cast<unsigned>(std::stoul(argv[3])))
      .run();
  return 0;
}
