#include <cmath>

#include "components/rounds.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

void measure_remote_sets(const Plan& plan, Report& report) {
  const std::uint64_t count = plan.is_quick ? 10'000 : 200'000;
  std::vector<Json> rounds;
  std::uint64_t faults = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    rounds.push_back(commands_round(plan.new_meeting(), count));
    faults += rounds.back().at("faults").get<std::uint64_t>();
  }
  const auto rate = std::round(median_of(rounds, "per_second"));
  report.figure("remote_sets_per_second", rate);
  report.figure("remote_set_faults", faults);
  report.target("remote_sets_per_second", "at least 50000", rate >= 50'000);
  report.target("remote_set_faults", "0", faults == 0);
  report.detail("remote_sets_per_second",
                {{"method",
                  "sets with replies, at most 4000 under way, 64-byte values, 100 tuples; first set to last reply; "
                  "faults: not applied, lost, repeated or out of order"},
                 {"rounds", rounds}});
}

}  // namespace rubicon::bench::peis
