#include <fmt/format.h>

#include "apps/simulators/motes/computer.h"
#include "motes/mote_records.h"
#include "motes/rig.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using namespace motes_simulator;

constexpr int kEnergyMotes = 20;

/// Receives everything in a cell of the radio, and sends nothing.
class Listener final : public RadioNode {
 public:
  bool hear(const AirMessage& message) override {
    if (message.type != kAirNetMessage) return ++kinds_["joins"], false;
    const auto net = rubicon::motes::decode_net(message.payload);
    const auto record = net ? rubicon::motes::decode_record(*net) : Result<rubicon::motes::Record>();
    if (!record) return ++kinds_["others"], false;
    if (const auto* command = std::get_if<rubicon::motes::PeriodicCommand>(&*record)) {
      ++kinds_["periodic_commands"];
      masks_[net->destination_mote] = command->transducers;
    } else if (std::holds_alternative<rubicon::motes::MoteAck>(*record)) {
      ++kinds_["acknowledgements"];
    } else if (std::holds_alternative<rubicon::motes::DemoReport>(*record)) {
      ++kinds_["reports"];
      ++reports_[net->source_mote];
    } else {
      ++kinds_[net->source_mote == rubicon::motes::kBaseMote ? "probes" : "others"];
    }
    return false;
  }

  /// The traffic since the last call.
  Json take() {
    Json found;
    for (const auto& [kind, count] : kinds_) found[kind] = count;
    for (const auto& [mote, count] : reports_) found["reports_of"][std::to_string(mote)] = count;
    for (const auto& [mote, mask] : masks_) found["masks"][std::to_string(mote)] = fmt::format("{:04x}", mask);
    kinds_.clear();
    reports_.clear();
    masks_.clear();
    return found;
  }
  std::uint64_t reports() const {
    const auto found = kinds_.find("reports");
    return found == kinds_.end() ? 0 : found->second;
  }

 private:
  std::map<std::string, std::uint64_t> kinds_;
  std::map<std::uint16_t, std::uint64_t> reports_;
  std::map<std::uint16_t, std::uint16_t> masks_;
};

/// The traffic if a computer commands each mote to report once a second, and nothing else.
std::uint64_t peer_reports(const Plan& plan) {
  VirtualScheduler time;
  auto options = world_of(1, kEnergyMotes);
  options.wait_for_computer = false;
  World world(options, time);
  Listener listener;
  world.radio().add(listener, {1});
  const Computer computer({11, 1024, false}, world.sink(1), time);
  time.run_for(10s);
  std::ignore = listener.take();
  time.run_for(plan.quiet);
  return listener.reports();
}

}  // namespace

void measure_energy(const Plan& plan, Json& out) {
  VirtualRig rig(1, kEnergyMotes);
  Listener listener;
  rig.world->radio().add(listener, {1});
  const auto island =
      start_island(island_of(ports_of(1), "silence: 60s, share: no"), rig.time, rig.transports, rig.ecology);
  Component component(rig.ecology, rig.time, 70001);
  rig.time.run_for(10s);
  Json figures{{"motes", kEnergyMotes}, {"minutes", plan.quiet.count()}};
  figures["joining"] = listener.take();
  rig.time.run_for(plan.quiet);
  figures["before_the_first_subscriber"] = listener.take();
  auto subscription =
      component->subscribe({kIslandOwner, "proxy.wsn-1.7.sensor.light-1.value"}, {}, [](const tuples::Event&) {});
  rig.time.run_for(plan.quiet);
  figures["one_sensor_of_mote_7"] = listener.take();
  subscription.reset();
  rig.time.run_for(plan.quiet);
  figures["after_the_last_subscriber"] = listener.take();
  figures["peer_reports_all_each_second"] = peer_reports(plan);
  out["energy"] = figures;
}

}  // namespace rubicon::bench::motes
