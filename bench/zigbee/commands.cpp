#include <fmt/format.h>

#include <map>

#include "support/process.h"
#include "zigbee/real_rig.h"
#include "zigbee/records.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;

constexpr auto kBetween = 4ms;
const std::string kFloorTopic = "bench/floor";

/// When things were sent, by topic or text; milliseconds until they arrived.
class Latencies {
 public:
  void sent(const std::string& what) { sent_[what] = Clock::now(); }
  void arrived(const std::string& what) {
    const auto found = sent_.find(what);
    if (found == sent_.end()) return;
    took_.push_back(milliseconds(Clock::now() - found->second));
    sent_.erase(found);
  }
  std::size_t waiting() const { return sent_.size(); }
  Json figures() const {
    return {{"p50_ms", rounded(median(took_), 3)},
            {"p99_ms", rounded(percentile(took_, 0.99), 3)},
            {"max_ms", rounded(percentile(took_, 1), 3)},
            {"lost", sent_.size()}};
  }

 private:
  std::map<std::string, Clock::time_point> sent_;
  std::vector<double> took_;
};

}  // namespace

/// A command for each of as many plugs: from the remote set of a component in this process to the arrival of the set
/// message at a client of the broker; and between them a line to a mosquitto_pub.
void measure_commands(const Plan& plan, Json& out) {
  RealRig rig(out, "commands");
  if (!rig) return;
  const auto records = device_records(plan.commands, "plug");
  Latencies ours, floor;
  const auto ear = rig.connect([&](const transport::MqttMessage& message) {
    message.topic == kFloorTopic ? floor.arrived(std::string(message.payload))
                                 : ours.arrived(std::string(message.topic));
  });
  must(ear->subscribe("zigbee2mqtt/+/set"));
  must(ear->subscribe(kFloorTopic));
  publish_bridge(*ear, list_of(records, records.size()));
  const auto island = start_island(rig.scheduler(), rig.transports(), rig.ecology());
  Component commander(rig.ecology(), rig.scheduler(), 70001);
  rig.run_until([&] { return listed_devices(*island).size() == records.size(); }, "the plugs do not join");
  support::Process other({"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(kPort), "-t", kFloorTopic, "-l"});
  rig.run(1s);
  int refused = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    ours.sent("zigbee2mqtt/" + name_of(records[i]) + "/set");
    commander->set_remote(
        kIsland, fmt::format("proxy.zigbee.{}.actuator.switch-1.command", address_of(records[i])), "on", 0s,
        [&refused](const tuples::Reply& reply) { refused += reply.verdict == tuples::Verdict::kApplied ? 0 : 1; });
    rig.run(kBetween / 2);
    floor.sent(std::to_string(i));
    other.write(fmt::format("{}\n", i));
    rig.run(kBetween / 2);
  }
  rig.run(1s);
  out["commands"] = {{"commands", records.size()},
                     {"refused", refused},
                     {"rubicon", ours.figures()},
                     {"mosquitto_pub", floor.figures()}};
}

}  // namespace rubicon::bench::zigbee
