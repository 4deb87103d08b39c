#include <CLI/CLI.hpp>

#include "components/roles.h"
#include "components/rounds.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

constexpr int kUsualCrowd = 50;
/// In a larger one each process has as much more to meet, and the processors are few.
constexpr double kSettled = 20, kSettledPerComponent = 0.4;
constexpr double kIdle = 5;

int& crowd_size() {
  static int size = kUsualCrowd;
  return size;
}

std::vector<double> each(const std::vector<Json>& crowd, const char* name) {
  std::vector<double> values;
  for (const auto& one : crowd) values.push_back(one.at(name));
  return values;
}

}  // namespace

void add_crowd_option(CLI::App& app) {
  app.add_option("--crowd", crowd_size(), "components of the crowd; DDS has 120 on a host")
      ->check(CLI::Range(2, 500))
      ->capture_default_str();
}

void measure_crowd(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 10 : crowd_size();
  const CrowdTimes times{std::max(kSettled, kSettledPerComponent * count), kIdle};
  auto children = start_crowd(plan.new_meeting(), count, plan.is_quick ? CrowdTimes{6, 1} : times);
  const auto crowd = results_of(children);
  const auto slowest = slowest_of(crowd);
  const auto idle = each(crowd, "idle_percent"), memory = each(crowd, "private_mb");
  const auto most = rounded(percentile(idle, 1), 2);
  int lost = 0;
  for (const auto& one : crowd) lost += one.at("lost_peers").get<int>();
  report.figure("all_see_all_s", slowest > 0 ? Json(rounded(slowest, 2)) : Json(nullptr));
  report.figure("idle_cpu_percent", rounded(median(idle), 2));
  report.figure("crowd_private_mb", rounded(median(memory), 2));
  report.figure("crowd_lost", lost);
  report.target("all_see_all_s", "under 10", slowest > 0 && slowest < 10);
  report.target("idle_cpu_percent", "under 1 each", most < 1);
  report.target("crowd_lost", "0", lost == 0);
  report.detail("all_see_all_s", {{"components", count},
                                  {"idle_cpu_percent_most", most},
                                  {"private_mb_most", rounded(percentile(memory, 1), 2)},
                                  {"resident_mb", rounded(median(each(crowd, "resident_mb")), 2)}});
}

}  // namespace rubicon::bench
