#include <cmath>

#include "components/roles.h"
#include "components/rounds.h"
#include "sites/broker.h"
#include "sites/measurements.h"

namespace rubicon::bench::sites {

void measure_remote_sets(const Plan& plan, Report& report) {
  const Broker broker(plan, report, "remote_sets");
  if (!broker) return;
  const std::uint64_t count = plan.is_quick ? 10'000 : 200'000;
  std::vector<Json> rounds;
  std::uint64_t all = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    rounds.push_back(commands_round(broker.new_meeting(plan), count));
    all += rounds.back().at("faults").get<std::uint64_t>();
  }
  const auto rate = std::round(median_of(rounds, "per_second"));
  report.figure("remote_sets_per_second", rate);
  report.figure("remote_set_faults", all);
  report.target("remote_sets_per_second", "at least 30000", rate >= 30'000);
  report.target("remote_set_faults", "0", all == 0);
  report.detail("remote_sets_per_second",
                {{"method",
                  "sets with replies, at most 4000 under way, 64-byte values, 100 tuples; first set to last reply; "
                  "faults: not applied, lost, repeated or out of order"},
                 {"rounds", rounds}});
}

void measure_join(const Plan& plan, Report& report) {
  const Broker broker(plan, report, "join");
  if (!broker) return;
  constexpr int kTuples = kJoinedDevices * kJoinedSensors;
  const auto meeting = broker.new_meeting(plan);
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
                                   "from the start of a component, which connects and subscribes to all 100000 tuples "
                                   "of another one, to the last value; seconds: from subscribe() on"},
                                  {"rounds", rounds}});
}

}  // namespace rubicon::bench::sites
