#include <fmt/format.h>

#include <thread>

#include "components/rounds.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

void measure_together(const Plan& plan, Report& report, int count) {
  const auto times = plan.is_quick ? CrowdTimes{15, 1} : CrowdTimes{};
  auto all = start_crowd(plan.new_meeting(), count, times);
  const auto results = results_of(all);
  std::vector<double> idle;
  int lost = 0;  // although all were there
  for (const auto& one : results) {
    idle.push_back(one.at("idle_percent"));
    lost += one.at("lost_peers").get<int>();
  }
  const auto seen = slowest_of(results), most = percentile(idle, 1);
  report.figure("all_see_all_s", seen > 0 ? Json(rounded(seen, 2)) : Json(nullptr));
  report.figure("idle_cpu_percent", rounded(median(idle), 3));
  report.target("all_see_all_s", "under 8", seen > 0 && seen < 8);
  report.target("idle_cpu_percent", "under 0.5 each", most < 0.5);
  report.detail("all_see_all_s", {{"components", count},
                                  {"idle_s", times.idle},
                                  {"lost_peers", lost},
                                  {"idle_cpu_percent_most", rounded(most, 3)}});
}

/// One more than those that are there, several times.
void measure_newcomers(const Plan& plan, Report& report, int count) {
  const double stay = plan.is_quick ? 15 : 3;
  const CrowdTimes times{10.0, 0};
  const auto meeting = plan.new_meeting();
  auto residents = start_crowd(meeting, count, {times.settled + (stay + 2) * plan.rounds + 1, 0});
  std::this_thread::sleep_for(std::chrono::duration<double>(times.settled));
  std::vector<Json> rounds;
  for (int round = 0; round < plan.rounds; ++round) {
    auto one = start_role("one-of-many", meeting,
                          {{"number", count + round},
                           {"count", count + 1},
                           {"begin", wall_seconds()},
                           {"settled_s", stay},
                           {"idle_s", 0}});
    rounds.push_back(result_of(one));
    rounds.back().erase("idle_percent");  // of no time
  }
  (void)results_of(residents);
  const auto seen = slowest_of(rounds);
  const auto middle = rounded(median_of(rounds, "seen_s"), 2);
  report.figure("newcomer_sees_all_s", seen > 0 ? Json(middle) : Json(nullptr));
  report.target("newcomer_sees_all_s", "under 2", seen > 0 && middle < 2);
  report.detail("newcomer_sees_all_s", {{"others", count}, {"slowest", rounded(seen, 2)}, {"rounds", rounds}});
}

}  // namespace

void measure_crowd(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 5 : 30;
  measure_together(plan, report, count);
  measure_newcomers(plan, report, count - 1);
}

}  // namespace rubicon::bench::peis
