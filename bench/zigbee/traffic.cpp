#include <fmt/format.h>

#include <stdexcept>

#include "base/text.h"
#include "frame/daemon.h"
#include "frame/process_figures.h"
#include "zigbee/real_rig.h"
#include "zigbee/records.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kDomain = 197;
constexpr int kMessagesPerSecond = 603;

/// Publishes reports of the devices in turn, at an even pace.
class Reports {
 public:
  Reports(RealRig& rig, transport::MqttLine& line, std::vector<std::string> topics)
      : rig_(rig), line_(line), topics_(std::move(topics)), began_(Clock::now()) {
    tick();
  }
  int published() const { return published_; }

 private:
  void tick() {
    const auto due = static_cast<int>(seconds_since(began_) * kMessagesPerSecond);
    for (; published_ < due; ++published_) {
      transport::MqttPublication publication;
      publication.topic = topics_[static_cast<std::size_t>(published_) % topics_.size()];
      publication.payload = state_text(rig_.scheduler().wall_now(), published_);
      must(line_.publish(std::move(publication)));
    }
    next_ = rig_.scheduler().after(5ms, [this] { tick(); });
  }

  RealRig& rig_;
  transport::MqttLine& line_;
  std::vector<std::string> topics_;
  Clock::time_point began_;
  int published_ = 0;
  Timer next_;
};

}  // namespace

/// The daemon while each of the devices reports every half second.
void measure_traffic(const Plan& plan, Json& out) {
  RealRig rig(out, "traffic");
  if (!rig) return;
  const auto records = device_records(plan.devices, "thermometer");
  std::vector<std::string> topics;
  for (const auto& record : records) topics.push_back("zigbee2mqtt/" + name_of(record));
  const auto line = rig.connect([](const transport::MqttMessage&) {});
  publish_bridge(*line, list_of(records, records.size()));
  const Daemon daemon(island_yaml(), kDomain);
  const auto ecology = join_on_loopback(kDomain, rig.scheduler());
  Component watcher(*ecology, rig.scheduler(), 70001);
  std::size_t listed = 0;
  std::uint64_t seen = 0;
  const auto list = watcher->subscribe({kIsland, "proxy.zigbee.property.devices.value"}, {.passive = true},
                                       [&listed](const tuples::Event& event) {
                                         listed = base::parse_number<std::size_t>(event.tuple.value).value_or(0);
                                       });
  rig.run_until([&] { return listed == records.size(); }, "the devices do not join");
  const auto value =
      watcher->subscribe({kIsland, fmt::format("proxy.zigbee.{}.sensor.temperature-1.value", address_of(records[0]))},
                         {.passive = true}, [&seen](const tuples::Event&) { ++seen; });
  Reports reports(rig, *line, topics);
  rig.run(3s);
  const auto before = daemon.processor();
  const auto broker_before = processor_seconds(rig.broker().process().pid());
  const auto sent_before = reports.published();
  const auto began = Clock::now();
  rig.run(plan.traffic);
  const auto took = seconds_since(began);
  if (seen == 0) throw std::runtime_error("no report became a tuple");
  out["traffic"] = {{"devices", records.size()},
                    {"messages_per_second", rounded((reports.published() - sent_before) / took, 1)},
                    {"cpu_percent", rounded((daemon.processor() - before) / took * 100, 2)},
                    {"resident_mb", daemon.resident_mb()},
                    {"mosquitto_cpu_percent",
                     rounded((processor_seconds(rig.broker().process().pid()) - broker_before) / took * 100, 2)}};
}

}  // namespace rubicon::bench::zigbee
