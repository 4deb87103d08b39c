#include <cmath>

#include "components/roles.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

void measure_remote_sets(const Plan& plan, Report& report) {
  const std::uint64_t count = plan.is_quick ? 10'000 : 200'000;
  std::vector<Json> rounds;
  std::uint64_t faults = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto meeting = plan.new_meeting();
    auto owning = start_role("desk", meeting, {{"count", count}});
    auto commanding = start_role("commander", meeting, {{"count", count}});
    auto sent = result_of(commanding);
    const auto judged = result_of(owning);
    faults += sent.at("not_applied").get<std::uint64_t>();
    for (const auto* fault : {"lost", "twice", "out_of_order"}) faults += judged.at(fault).get<std::uint64_t>();
    sent["judged"] = judged;
    rounds.push_back(sent);
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
