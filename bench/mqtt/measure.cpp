#include <fmt/format.h>
#include <unistd.h>

#include <map>
#include <set>

#include "frame/process_figures.h"
#include "mqtt/bare_publisher.h"
#include "mqtt/measurements.h"
#include "mqtt/town.h"

namespace rubicon::bench::mqtt {

namespace {

using namespace std::chrono_literals;
using zigbee::RealRig;

/// What another client gets of a town, as Home Assistant does.
struct Seen {
  std::set<std::string> announced, states;
  void take(const transport::MqttMessage& message) {
    if (message.topic.ends_with("/config")) announced.emplace(message.topic);
    if (message.topic.find("/sensor/") != message.topic.npos && !message.topic.ends_with("/online"))
      states.emplace(message.topic);
  }
  bool all(int devices) const {
    const auto wanted = static_cast<std::size_t>(devices);
    return announced.size() >= wanted + 2 && states.size() >= wanted * Town::kPoints;
  }
};

std::unique_ptr<transport::MqttLine> watch(RealRig& rig, Seen& seen) {
  auto line = rig.connect([&seen](const transport::MqttMessage& message) { seen.take(message); });
  must(line->subscribe("homeassistant/device/+/config"));
  must(line->subscribe("rubicon/#"));
  return line;
}

/// Readings at an even pace, each by one call.
class Readings {
 public:
  Readings(RealRig& rig, int per_second, std::function<void(std::size_t)> one)
      : rig_(rig), per_second_(per_second), one_(std::move(one)), began_(Clock::now()) {
    tick();
  }
  std::size_t made() const { return made_; }

 private:
  void tick() {
    const auto due = static_cast<std::size_t>(seconds_since(began_) * per_second_);
    for (; made_ < due; ++made_) one_(made_);
    next_ = rig_.scheduler().after(1ms, [this] { tick(); });
  }

  RealRig& rig_;
  int per_second_;
  std::function<void(std::size_t)> one_;
  Clock::time_point began_;
  std::size_t made_ = 0;
  Timer next_;
};

/// Processor time of this process for each reading, in us.
double cost(RealRig& rig, const Plan& plan, const std::function<void(std::size_t)>& one) {
  const auto before = processor_seconds(::getpid());
  const Readings readings(rig, plan.readings_per_second, one);
  rig.run(plan.mirrored);
  return (processor_seconds(::getpid()) - before) / static_cast<double>(std::max<std::size_t>(readings.made(), 1)) *
         1e6;
}

std::string value_of(std::size_t reading) {
  return fmt::format("{:.2f}", 20 + static_cast<double>(reading % 100) / 100);
}

}  // namespace

/// From the start of the bridge until another client has all.
void measure_announcement(const Plan& plan, Json& out) {
  RealRig rig(out, "announcement");
  if (!rig) return;
  Town town(rig, plan.devices);
  rig.run(100ms);
  Seen seen;
  const auto line = watch(rig, seen);
  rig.run(500ms);
  const auto memory = private_mb();
  const auto began = Clock::now();
  town.start_bridge();
  rig.run_until([&] { return seen.all(plan.devices); }, "not all is announced");
  out["announced_s"] = rounded(seconds_since(began), 3);
  out["announced_mb"] = rounded(private_mb() - memory, 1);
}

/// What mirroring costs beside a client of libmosquitto that publishes the same bytes at the same pace.
void measure_mirror(const Plan& plan, Json& out) {
  RealRig rig(out, "mirror");
  if (!rig) return;
  Town town(rig, plan.devices);
  rig.run(100ms);
  const auto read = [&](std::size_t reading) { town.read(reading % town.sensors(), value_of(reading)); };
  const auto island = cost(rig, plan, read);
  auto line = rig.connect([](const transport::MqttMessage&) {});
  const auto through_line = cost(rig, plan, [&](std::size_t reading) {
    std::ignore = line->publish(
        {town.topic(reading % town.sensors()), value_of(reading), true, 0, transport::MqttQueue::kLatest});
  });
  line.reset();
  rig.run(2s);  // the thread of the line has ended: its time would count
  auto publisher = std::make_unique<BarePublisher>(zigbee::kPort);
  const auto bare = cost(rig, plan, [&](std::size_t reading) {
    publisher->publish(town.topic(reading % town.sensors()), value_of(reading));
  });
  publisher.reset();
  town.start_bridge();
  rig.run(plan.settled);
  const auto sent = town.bridge().status().counters.at("sent");
  const auto both = cost(rig, plan, read);
  out["mirrored"] = town.bridge().status().counters.at("sent") - sent;
  out["island_us"] = rounded(island, 2);
  out["bare_publisher_us"] = rounded(bare, 2);
  out["line_us"] = rounded(through_line, 2);
  out["mirror_us"] = rounded(both - island, 2);
  out["mirror_ratio"] = rounded((both - island) / bare, 2);
  out["mirror_dropped"] = town.bridge().status().counters.at("dropped");
}

/// From a message on a command topic until the island has the set, beside a message to another client.
void measure_commands(const Plan& plan, Json& out) {
  RealRig rig(out, "commands");
  if (!rig) return;
  Town town(rig, 1);
  std::size_t sets = 0, answers = 0;
  const auto policy = town.island().add_policy(Pattern::parse("**").value(), [&](const tuples::RemoteSet&) {
    ++sets;
    return tuples::SetDecision::refused({ErrorCode::kRefused, "measured"});
  });
  town.start_bridge();
  rig.run(1s);
  const auto line = rig.connect([&](const transport::MqttMessage&) { ++answers; });
  must(line->subscribe("bare"));
  rig.run(200ms);
  const auto measure = [&](const std::string& topic, const std::size_t& counter) {
    std::vector<double> times;
    for (int i = 0; i < plan.commands; ++i) {
      const auto before = counter;
      const auto began = Clock::now();
      must(line->publish({topic, "1", false, 1}));
      const auto poll = [&](const auto& again) -> void {
        if (counter > before || seconds_since(began) > 5) return rig.loop().stop();
        rig.scheduler().post([&again] { again(again); });
      };
      rig.scheduler().post([&poll] { poll(poll); });
      rig.loop().run();
      times.push_back(milliseconds(Clock::now() - began));
    }
    return percentile(times, 0.99);
  };
  const auto bare = measure("bare", answers);
  const auto command = measure(town.topic(0) + "/set", sets);
  out["command_p99_ms"] = rounded(command, 2);
  out["bare_p99_ms"] = rounded(bare, 2);
  out["commands_lost"] =
      plan.commands - static_cast<int>(std::min<std::size_t>(sets, static_cast<std::size_t>(plan.commands)));
}

void measure_restarts(const Plan& plan, Json& out) {
  RealRig rig(out, "restarts");
  if (!rig) return;
  Town town(rig, plan.devices);
  town.start_bridge();
  rig.run(1s);
  double longest = 0;
  for (int i = 0; i < plan.restarts; ++i) {
    rig.broker().kill();
    rig.broker().start();
    rig.await_broker();
    const auto began = Clock::now();
    Seen seen;
    const auto line = watch(rig, seen);
    rig.run_until([&] { return seen.all(plan.devices); }, "not all came again");
    longest = std::max(longest, seconds_since(began));
  }
  out["right_after_restart_s"] = rounded(longest, 2);
}

void measure_idle(const Plan& plan, Json& out) {
  RealRig rig(out, "idle");
  if (!rig) return;
  Town town(rig, plan.devices);
  town.start_bridge();
  rig.run(5s);
  const auto before = processor_seconds(::getpid());
  rig.run(plan.idle);
  out["idle_percent"] =
      rounded((processor_seconds(::getpid()) - before) / std::chrono::duration<double>(plan.idle).count() * 100, 2);
}

}  // namespace rubicon::bench::mqtt
