#include <fmt/format.h>

#include "components/roles.h"
#include "components/rounds.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

void tell(Report& report, const std::string& name, const std::vector<Json>& runs, double most) {
  const auto seconds = rounded(median_of(runs, "seconds"), 4);
  report.figure(name, seconds);
  report.target(name, fmt::format("under {}", most), seconds < most);
  report.detail(name, {{"method", "from subscribe() of a program that sees the island to the last initial value"},
                       {"with_start_of_program_s", rounded(median_of(runs, "with_start"), 4)},
                       {"rounds", runs}});
}

}  // namespace

void measure_joins(const Plan& plan, Report& report) {
  const auto meeting = plan.new_meeting();
  auto owner = start_role("island", meeting, {{"joiners", 2 * plan.rounds}});
  std::vector<Json> all, few;
  const auto join = [&](const char* pattern, int expected) {
    auto joining = start_role("joiner", meeting, {{"pattern", pattern}, {"expected", expected}});
    return result_of(joining);
  };
  for (int round = 0; round < plan.rounds; ++round) {
    all.push_back(join("proxy.**", kJoinedDevices * kJoinedSensors));
    few.push_back(join("proxy.wsn-1.device-500.**", kJoinedSensors));
  }
  (void)result_of(owner);
  tell(report, "join_all_s", all, 1.5);
  tell(report, "join_100_s", few, 0.1);
}

}  // namespace rubicon::bench
