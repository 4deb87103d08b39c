#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "frame/process_figures.h"
#include "zigbee/records.h"
#include "zigbee/rig.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kPerTurn = 64;

/// Reports of the devices in turn; seconds of processor time until all that follows is done.
double report(VirtualRig& rig, const std::vector<std::string>& topics, int states) {
  double spent = 0;
  const auto per_turn = std::min(kPerTurn, topics.size());
  std::vector<std::string> payloads(per_turn);
  for (std::size_t done = 0; done < static_cast<std::size_t>(states); done += per_turn) {
    for (std::size_t i = 0; i < per_turn; ++i)
      payloads[i] = state_text(rig.time.wall_now(), static_cast<int>((done + i) / topics.size() + done + i));
    const auto start = thread_seconds();
    for (std::size_t i = 0; i < per_turn; ++i) rig.transports.deliver(topics[(done + i) % topics.size()], payloads[i]);
    rig.virtual_time.run_for(10ms);
    spent += thread_seconds() - start;
  }
  return spent;
}

/// How often the tuples of the temperatures were set.
std::uint64_t temperatures(VirtualRig& rig, const std::vector<std::string>& records) {
  std::uint64_t sets = 0;
  for (const auto& record : records) {
    const auto value =
        rig.island->space().get(kIsland, fmt::format("proxy.zigbee.{}.sensor.temperature-1.value", address_of(record)));
    sets += value ? value->sequence : 0;
  }
  return sets;
}

}  // namespace

void measure_states(const Plan& plan, Json& out) {
  const auto records = device_records(plan.devices, "thermometer");
  std::vector<std::string> topics;
  for (const auto& record : records) topics.push_back("zigbee2mqtt/" + name_of(record));
  std::vector<double> rates;
  for (int round = 0; round < plan.rounds; ++round) {
    VirtualRig rig;
    rig.begin(list_of(records, records.size()));
    report(rig, topics, 2 * static_cast<int>(topics.size()));
    const auto before = temperatures(rig, records);
    const auto spent = report(rig, topics, plan.states);
    const auto sets = temperatures(rig, records) - before;
    if (sets < static_cast<std::uint64_t>(plan.states))
      throw std::runtime_error(fmt::format("{} of {} states became tuples", sets, plan.states));
    rates.push_back(plan.states / spent);
  }
  out["states"] = {{"bytes", state_text(WallTime{}, 1).size()}, {"per_second", rounded(median(rates), 0)}};
}

}  // namespace rubicon::bench::zigbee
