#include <fmt/format.h>

#include <cmath>

#include "components/roles.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

void measure_remote_sets(const Plan& plan, Report& report) {
  const std::uint64_t count = plan.is_quick ? 40'000 : 400'000;
  std::vector<double> rates;
  std::uint64_t lost = 0, twice = 0, out_of_order = 0, refused = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto meeting = plan.new_meeting();
    auto owning = start_role("desk", meeting, {{"count", count}});
    auto commanding = start_role("commander", meeting, {{"count", count}});
    const auto sent = result_of(commanding), judged = result_of(owning);
    rates.push_back(sent.at("per_second"));
    refused += sent.at("not_applied").get<std::uint64_t>();
    lost += judged.at("lost").get<std::uint64_t>();
    twice += judged.at("twice").get<std::uint64_t>();
    out_of_order += judged.at("out_of_order").get<std::uint64_t>();
  }
  const auto rate = std::round(median(rates));
  report.figure("remote_sets_per_second", rate);
  report.figure("lost", lost);
  report.figure("twice", twice);
  report.figure("out_of_order", out_of_order);
  report.target("remote_sets_per_second", "at least 80000", rate >= 80'000);
  report.target("lost", "0, and none refused", lost == 0 && refused == 0);
  report.target("twice", "0", twice == 0);
  report.target("out_of_order", "0", out_of_order == 0);
  report.detail("remote_sets_per_second",
                {{"method", fmt::format("{} sets with replies, at most 4000 under way, 64-byte values, 100 tuples; "
                                        "first set to last reply",
                                        count)},
                 {"rounds", rates},
                 {"not_applied", refused}});
}

}  // namespace rubicon::bench
