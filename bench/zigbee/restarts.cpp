#include <fmt/format.h>

#include <map>

#include "apps/simulators/zigbee/world.h"
#include "zigbee/real_rig.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;
using zigbee_simulator::World;

constexpr int kDevices = 30;
constexpr auto kBetweenCommands = 50ms;

/// The simulator's world at the broker; notes each set that reaches it.
class Bridge {
 public:
  explicit Bridge(RealRig& rig) : rig_(rig), world_(options(), rig.scheduler(), Log(nowhere(), "world")) {
    for (int i = 0; i < kDevices; ++i)
      std::ignore = world_.add(*zigbee_simulator::find_model(i % 2 == 0 ? "lamp" : "thermometer"));
    world_.topics().publish = [this](transport::MqttPublication message) {
      if (connected_) std::ignore = line_->publish(std::move(message));
    };
    open();
  }
  std::map<std::string, int> sets;  ///< topic and payload -> how often
  std::vector<std::string> lamps() {
    std::vector<std::string> names;
    for (auto* device : world_.registry().devices()) {
      if (device->model().values.contains("brightness")) names.push_back(device->address().substr(2));
    }
    return names;
  }

 private:
  static zigbee_simulator::WorldOptions options() {
    zigbee_simulator::WorldOptions options;
    options.every = 500ms;
    return options;
  }
  void open() {
    line_.reset();
    transport::MqttOptions options;
    options.host = "127.0.0.1";
    options.port = kPort;
    options.will = transport::MqttWill{"zigbee2mqtt/bridge/state", R"({"state":"offline"})"};
    transport::MqttCallbacks calls;
    calls.connected = [this](const transport::MqttConnack&) {
      connected_ = true;
      for (const auto* filter : {"zigbee2mqtt/+/set", "zigbee2mqtt/+/get", "zigbee2mqtt/bridge/request/#"})
        must(line_->subscribe(filter));
      std::exchange(started_, true) ? world_.reconnected() : world_.start();
    };
    calls.received = [this](const transport::MqttMessage& message) {
      if (message.topic.ends_with("/set")) ++sets[fmt::format("{} {}", message.topic, message.payload)];
      world_.received(message.topic, message.payload);
    };
    calls.refused = [](std::string_view, const Error&) {};
    calls.failed = [this](const Error&) {
      connected_ = false;
      again_ = rig_.scheduler().after(50ms, [this] { open(); });
    };
    auto opened = rig_.transports().open_mqtt(options, std::move(calls));
    if (opened) line_ = std::move(*opened);
    if (!opened) again_ = rig_.scheduler().after(50ms, [this] { open(); });
  }

  RealRig& rig_;
  World world_;
  std::unique_ptr<transport::MqttLine> line_;
  bool connected_ = false, started_ = false;
  Timer again_;
};

/// Commands the lamps in turn, each time to a level that this lamp never had.
class Commands {
 public:
  Commands(RealRig& rig, std::vector<std::string> lamps)
      : rig_(rig), lamps_(std::move(lamps)), commander_(rig.ecology(), rig.scheduler(), 70001) {
    tick();
  }
  std::uint64_t sent() const { return sent_; }

 private:
  void tick() {
    const auto lamp = sent_ % lamps_.size();
    const auto level = 1 + sent_ / lamps_.size() % 254;
    commander_->set_remote(kIsland, fmt::format("proxy.zigbee.{}.actuator.dimmer-1.command", lamps_[lamp]),
                           fmt::format("{:.4f}", static_cast<double>(level) / 2.54), 0s, [](const tuples::Reply&) {});
    ++sent_;
    next_ = rig_.scheduler().after(kBetweenCommands, [this] { tick(); });
  }

  RealRig& rig_;
  std::vector<std::string> lamps_;
  Component commander_;
  std::uint64_t sent_ = 0;
  Timer next_;
};

Json restarts(const Plan& plan, RealRig& rig, bool persistent) {
  Bridge bridge(rig);
  const auto island = start_island(rig.scheduler(), rig.transports(), rig.ecology());
  rig.run_until([&] { return listed_devices(*island).size() == kDevices; }, "the devices do not join");
  const auto keys = listed_devices(*island);
  int joins = 0, leaves = 0;
  const auto hear_joins = island->gateway().subscribe(MessageKind::kJoin, [&](const Message&) { ++joins; });
  const auto hear_leaves = island->gateway().subscribe(MessageKind::kLeave, [&](const Message&) { ++leaves; });
  Commands commands(rig, bridge.lamps());
  std::vector<double> back;
  for (int i = 0; i < plan.restarts; ++i) {
    rig.run(1s);
    persistent ? rig.broker().stop() : rig.broker().kill();
    rig.run_until([&] { return line_of(*island) != "up"; }, "the island does not notice that the broker is gone");
    rig.broker().start();
    rig.await_broker();
    const auto start = Clock::now();
    rig.run_until([&] { return line_of(*island) == "up"; }, "the line does not come up");
    back.push_back(milliseconds(Clock::now() - start));
  }
  rig.run(2s);
  int twice = 0, executed = 0;
  for (const auto& [set, times] : bridge.sets) {
    ++executed;
    twice += times > 1 ? 1 : 0;
  }
  return {{"restarts", plan.restarts},
          {"back_ms", {{"median", rounded(median(back), 0)}, {"worst", rounded(percentile(back, 1), 0)}}},
          {"devices", keys.size()},
          {"same_keys", listed_devices(*island) == keys},
          {"joins_again", joins},
          {"leaves", leaves},
          {"commands", commands.sent()},
          {"executed", executed},
          {"executed_twice", twice}};
}

}  // namespace

void measure_restarts(const Plan& plan, Json& out) {
  for (const bool persistent : {false, true}) {
    const auto* what = persistent ? "restarts_persistent" : "restarts";
    RealRig rig(out, what, persistent);
    if (rig) out[what] = restarts(plan, rig, persistent);
  }
}

}  // namespace rubicon::bench::zigbee
