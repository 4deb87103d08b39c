#include <fmt/format.h>

#include <chrono>
#include <csignal>

#include "components/rounds.h"
#include "sites/broker.h"
#include "sites/engine.h"
#include "sites/measurements.h"

namespace rubicon::bench::sites {

void measure_death(const Plan& plan, Report& report) {
  const Broker broker(plan, report, "death");
  if (!broker) return;
  const auto meeting = broker.new_meeting(plan);
  const auto lease = std::chrono::duration<double>(space_options(meeting).lease).count();
  const auto one = [&](const std::string& name, int signal, int rounds, double most) {
    std::vector<double> times;
    for (int round = 0; round < rounds; ++round)
      times.push_back(rounded(end_round(broker.new_meeting(plan), signal), 3));
    const auto slowest = percentile(times, 1);
    report.figure(name, slowest);
    report.target(name, fmt::format("under {}", most), slowest < most);
    report.detail(name, {{"method", "from the signal to the end of demand at the owner; the slowest round"},
                         {"lease_s", lease},
                         {"rounds", times}});
  };
  one("owner_learns_of_killed_s", SIGKILL, plan.rounds, 4);
  if (!plan.is_quick) one("owner_learns_of_stopped_s", SIGSTOP, 3, lease + 1);
}

void measure_crowd(const Plan& plan, Report& report) {
  const Broker broker(plan, report, "crowd");
  if (!broker) return;
  const int count = plan.is_quick ? 5 : 50;
  CrowdTimes times{20.0, plan.is_quick ? 1.0 : 10.0, true};
  auto crowd = start_crowd(broker.new_meeting(plan), count, times);
  const auto results = results_of(crowd);
  const auto seen = rounded(slowest_of(results), 2);
  std::vector<double> idle;
  for (const auto& one : results) idle.push_back(one.at("idle_percent"));
  report.figure("all_see_all_s", seen > 0 ? Json(seen) : Json(nullptr));
  report.target("all_see_all_s", "under 5", seen > 0 && seen < 5);
  report.detail("all_see_all_s",
                {{"method", "from the start of the first of so many processes until the last one sees all others"},
                 {"components", count},
                 {"idle_cpu_percent", rounded(median(idle), 3)},
                 {"idle_cpu_percent_most", rounded(percentile(idle, 1), 3)}});
}

}  // namespace rubicon::bench::sites
