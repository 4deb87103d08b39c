#include "components/rounds.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

void measure_join(const Plan& plan, Report& report) {
  constexpr int kTuples = 100'000;  // of the role `island`
  const auto meeting = plan.new_meeting();
  auto owner = start_role("island", meeting, {{"joiners", plan.rounds}});
  std::vector<Json> rounds;
  for (int round = 0; round < plan.rounds; ++round) {
    auto joining = start_role("joiner", meeting, {{"pattern", "proxy.**"}, {"expected", kTuples}});
    rounds.push_back(result_of(joining));
  }
  (void)result_of(owner);
  const auto seconds = rounded(median_of(rounds, "with_start"), 3);
  report.figure("join_100000_s", seconds);
  report.target("join_100000_s", "under 2", seconds < 2);
  report.detail("join_100000_s", {{"method",
                                   "from the start of a component, which searches the owner and subscribes to all of "
                                   "its 100000 tuples, to the last value; seconds: from subscribe() on"},
                                  {"rounds", rounds}});
}

}  // namespace rubicon::bench::peis
