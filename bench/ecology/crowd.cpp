#include "components/roles.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

constexpr double kSettled = 20, kIdle = 5;

}  // namespace

void measure_crowd(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 10 : 50;
  const auto meeting = plan.new_meeting();
  const auto begin = wall_seconds();
  std::vector<Child> all;
  all.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    all.push_back(
        start_role("one-of-many", meeting,
                   {{"number", i}, {"count", count}, {"begin", begin}, {"settled_s", kSettled}, {"idle_s", kIdle}}));
  double slowest = 0;
  bool complete = true;
  std::vector<double> idle;
  for (auto& one : all) {
    const auto result = result_of(one);
    complete = complete && result.at("seen_s").get<double>() > 0;
    slowest = std::max(slowest, result.at("seen_s").get<double>());
    idle.push_back(result.at("idle_percent"));
  }
  const auto most = rounded(percentile(idle, 1), 2);
  report.figure("all_see_all_s", complete ? Json(rounded(slowest, 2)) : Json(nullptr));
  report.figure("idle_cpu_percent", rounded(median(idle), 2));
  report.target("all_see_all_s", "under 10", complete && slowest < 10);
  report.target("idle_cpu_percent", "under 1 each", most < 1);
  report.detail("all_see_all_s", {{"components", count}, {"idle_cpu_percent_most", most}});
}

}  // namespace rubicon::bench
