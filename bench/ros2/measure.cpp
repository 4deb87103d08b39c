#include <dds/dds.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <vector>

#include "base/config_reader.h"
#include "bridges/bridge.h"
#include "frame/process_figures.h"
#include "model/point_tuples.h"
#include "ros2/measurements.h"
#include "ros_types.h"
#include "support/config_text.h"
#include "support/private_network.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "tuples/dds/entity.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bench::ros2 {

namespace {

using namespace std::chrono_literals;
using tuples::dds::Entity;
constexpr OwnerId kTown{6541}, kBridge{70000};
constexpr int kPoints = 5;

/// Another participant of a domain on loopback, as a robot in the same process.
class Other {
 public:
  explicit Other(dds_domainid_t inside, int domain = 0) {
    const auto xml = fmt::format(
        "<CycloneDDS xmlns='https://cdds.io/config'><Domain Id='any'><General><Interfaces><NetworkInterface name='lo' "
        "multicast='true'/></Interfaces><AllowMulticast>spdp</AllowMulticast></General><Discovery><ExternalDomainId>{}"
        "</ExternalDomainId><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>60"
        "</MaxAutoParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery></Domain></CycloneDDS>",
        domain);
    domain_ = Entity(dds_create_domain(inside, xml.c_str()));
    participant_ = Entity(dds_create_participant(inside, nullptr, nullptr));
  }
  dds_entity_t participant() const { return participant_.get(); }
  Entity end(const std::string& name, const dds_listener_t* listener, bool is_writer) const {
    auto qos = tuples::dds::make_qos();
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 10);
    const auto topic = dds_create_topic(participant(), &sensor_msgs_msg_dds__Temperature__desc, ("rt" + name).c_str(),
                                        nullptr, nullptr);
    return Entity(is_writer ? dds_create_writer(participant(), topic, qos.get(), listener)
                            : dds_create_reader(participant(), topic, qos.get(), listener));
  }

 private:
  Entity domain_, participant_;
};

/// Counts what its readers get, on the threads of DDS.
struct Count {
  std::atomic<std::uint64_t> all{0};
  std::atomic<std::int64_t> last_ns{0};
  tuples::dds::DdsListener listener{dds_create_listener(this)};

  Count() {
    dds_lset_data_available(listener.get(), [](dds_entity_t reader, void* count) {
      auto& mine = *static_cast<Count*>(count);
      mine.last_ns = Clock::now().time_since_epoch().count();
      mine.all += tuples::dds::take<std::byte>(reader, 1000, [](const auto&, const auto&) {});
    });
  }
};

/// An island of tuples and a bridge in a network of this process alone.
class Town {
 public:
  Town(const Plan& plan, Json& out, const std::string& what) {
    if (!network_.entered()) {
      out[what + "_skipped"] = network_.reason();
      return;
    }
    must(island_.describe(R"({"name":"town","prefix":"proxy"})"));
    must(island_.set("proxy.wsn.status", R"({"line":"up"})"));
    for (int i = 0; i < plan.devices; ++i) add_device(i);
    demand_ = island_.watch_demand(must(Pattern::parse("**")),
                                   [this](const auto& demand) { awake_ += demand.wanted ? 1 : -1; });
  }
  explicit operator bool() const { return network_.entered(); }
  void start_bridge() {
    const auto config = support::config_of(nlohmann::ordered_json{{"patterns", {"6541:proxy.**"}}});
    base::ConfigErrors errors;
    ConfigReader reader(config, "bridges.bench", errors);
    const bridges::BridgeHost host{"bench", loop_.scheduler(), space_, transports_, log_, kTown, "proxy"};
    bridge_ = bridges::find_bridge_type("ros2")->make(reader, "", &host);
    bridge_->start();
  }
  void read(std::size_t sensor, double value) { must(island_.set(values_[sensor], fmt::format("{:.3f}", value))); }
  std::uint64_t counter(const std::string& name) const { return bridge_->status().counters.at(name); }
  std::string topic(std::size_t sensor) const {
    return fmt::format("/town/wsn/d{}/temperature_{}", sensor / kPoints, sensor % kPoints + 1);
  }
  int awake() const { return awake_; }
  Scheduler& scheduler() { return loop_.scheduler(); }
  void run(Duration span) {
    const auto end = loop_.scheduler().after(span, [this] { loop_.stop(); });
    loop_.run();
  }
  template <class Done>
  void until(Done done) {
    for (int i = 0; i < 60'000 && !done(); ++i) run(1ms);
  }
  /// Turns until it is so, without a pause.
  template <class Done>
  void spin(Done done, double most_seconds = 5) {
    const auto began = Clock::now();
    const std::function<void()> again = [&] {
      if (done() || seconds_since(began) > most_seconds) return loop_.stop();
      scheduler().post(again);
    };
    scheduler().post(again);
    loop_.run();
  }

 private:
  void add_device(int number) {
    const auto device = fmt::format("proxy.wsn.{}", number);
    model::DeviceDescription about;
    about.name = fmt::format("Mote {}", number);
    std::string status;
    model::write_point_status({"good", "", {}, loop_.scheduler().wall_now(), {}, ""}, status);
    for (int i = 1; i <= kPoints; ++i) {
      about.sensors.push_back(fmt::format("temperature-{}", i));
      const auto key = fmt::format("{}.sensor.temperature-{}", device, i);
      model::PointDescription point;
      point.type = "temperature";
      point.unit = "Cel";
      point.data_type = "real";
      point.access = "read";
      point.report = "state";
      must(island_.set(key + ".description", model::point_description_to_json(point)));
      must(island_.set(key + ".status", status));
      values_.push_back(must(island_.set(key + ".value", "20")));
    }
    must(island_.set(device + ".status", R"({"status":"reachable"})"));
    must(island_.set(device + ".description", model::device_description_to_json(about)));
  }

  support::PrivateNetwork network_;
  transport::Loop loop_;
  transport::LocalTransports transports_{loop_};
  base::NullLogSink log_;
  tuples::MemoryEcology ecology_{loop_.scheduler()};
  std::unique_ptr<tuples::Link> island_link_ = must(ecology_.join(kTown)), bridge_link_ = must(ecology_.join(kBridge));
  TupleSpace island_{kTown, loop_.scheduler(), *island_link_}, space_{kBridge, loop_.scheduler(), *bridge_link_};
  std::vector<tuples::TupleRef> values_;
  Handle demand_;
  int awake_ = 0;
  std::unique_ptr<bridges::Bridge> bridge_;
};

std::size_t publications(dds_entity_t reader) {
  return tuples::dds::take<dds_builtintopic_endpoint_t>(reader, SIZE_MAX, [](const auto&, const auto&) {});
}

/// What each of `count` topics costs in bare DDS. Each has a writer; no other participant is in the domain.
double bare_topic_kb(std::size_t count) {
  const Other robot(202, 5);
  std::vector<Entity> writers;
  const auto before = private_mb();
  for (std::size_t i = 0; i < count; ++i)
    writers.push_back(
        robot.end(fmt::format("/town/wsn/d{}/temperature_{}", i / kPoints, i % kPoints + 1), nullptr, true));
  return rounded((private_mb() - before) * 1000 / static_cast<double>(count), 2);
}

}  // namespace

/// From the start of the bridge until another participant has all topics; what they cost.
void measure_topics(const Plan& plan, Json& out) {
  Town town(plan, out, "topics");
  if (!town) return;
  const auto all = static_cast<std::size_t>(plan.devices * kPoints);
  town.run(100ms);
  {
    Other other(200);
    const Entity reader(dds_create_reader(other.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
    const auto began = Clock::now();
    town.start_bridge();
    std::size_t seen = 0;
    town.until([&] { return (seen += publications(reader.get())) > all; });
    out["visible_s"] = rounded(seconds_since(began), 3);
  }
  Town second(plan, out, "topics");
  second.run(100ms);
  const auto before = private_mb();
  second.start_bridge();
  second.until([&] { return second.counter("topics") == all; });
  second.run(500ms);
  out["topic_kb"] = rounded((private_mb() - before) * 1000 / static_cast<double>(all), 2);
  out["bare_topic_kb"] = bare_topic_kb(all);
}

/// From a reading to the callback of a reader of ROS, beside a sample of bare DDS, one after the other.
void measure_latency(const Plan& plan, Json& out) {
  Town town(plan, out, "latency");
  if (!town) return;
  Other robot(200), bare(201);
  Count read, pinged;
  town.start_bridge();
  const auto reader = robot.end(town.topic(0), read.listener.get(), false);
  const auto ping = robot.end("/bare", pinged.listener.get(), false);
  const auto writer = bare.end("/bare", nullptr, true);
  town.until([&] { return town.awake() == 1; });
  town.run(1s);
  std::vector<double> readings, pings;
  std::string frame = "0";
  sensor_msgs_msg_dds__Temperature_ message{};
  message.header.frame_id = frame.data();
  const auto time = [&](Count& count, const std::function<void()>& send, std::vector<double>& times) {
    const auto before = count.all.load();
    const auto began = Clock::now();
    send();
    town.spin([&] { return count.all > before; });
    times.push_back(static_cast<double>(count.last_ns - began.time_since_epoch().count()) / 1000);
  };
  for (int i = 0; i < plan.pings; ++i) {
    time(
        pinged, [&] { dds_write(writer.get(), &message); }, pings);
    time(
        read, [&] { town.read(0, i); }, readings);
  }
  out["reading_p50_us"] = rounded(percentile(readings, 0.5), 1);
  out["reading_p99_us"] = rounded(percentile(readings, 0.99), 1);
  out["bare_p50_us"] = rounded(percentile(pings, 0.5), 1);
  out["bare_p99_us"] = rounded(percentile(pings, 0.99), 1);
  out["p50_ratio"] = rounded(percentile(readings, 0.5) / percentile(pings, 0.5), 2);
  out["p99_ratio"] = rounded(percentile(readings, 0.99) / percentile(pings, 0.99), 2);
}

/// Ten topics at 10,000 readings a second each.
void measure_flood(const Plan& plan, Json& out) {
  Town town(plan, out, "flood");
  if (!town) return;
  constexpr std::size_t kTopics = 10;
  constexpr double kPerSecond = 100'000;
  Other robot(200);
  Count read;
  town.start_bridge();
  std::vector<Entity> readers;
  for (std::size_t i = 0; i < kTopics; ++i) readers.push_back(robot.end(town.topic(i), read.listener.get(), false));
  town.until([&] { return town.awake() == static_cast<int>(kTopics); });
  town.run(500ms);
  std::uint64_t made = 0;
  const auto began = Clock::now();
  const auto length = std::chrono::duration<double>(plan.flood).count();
  town.spin(
      [&] {
        const auto now = std::min(seconds_since(began), length);
        // One reading of a sensor in a turn: of several only the newest leaves the island (docs/decisions/003).
        for (std::size_t i = 0; i < kTopics && static_cast<double>(made) < now * kPerSecond; ++i, ++made)
          town.read(i, static_cast<double>(made));
        return now >= length;
      },
      length + 5);
  for (auto before = made; read.all < made && read.all != before;) {  // what is lost never comes
    before = read.all;
    town.run(1s);
  }
  out["flood_per_s"] = rounded(static_cast<double>(made) / length, 0);
  out["flood_lost"] = made - std::min<std::uint64_t>(made, read.all);
}

void measure_idle(const Plan& plan, Json& out) {
  Town town(plan, out, "idle");
  if (!town) return;
  town.start_bridge();
  town.run(3s);
  const auto before = processor_seconds(::getpid());
  town.run(plan.idle);
  out["idle_percent"] =
      rounded((processor_seconds(::getpid()) - before) / std::chrono::duration<double>(plan.idle).count() * 100, 2);
  out["idle_awake"] = town.awake();
}

}  // namespace rubicon::bench::ros2
