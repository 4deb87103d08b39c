#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <numeric>
#include <thread>

#include "components/roles.h"
#include "components/rounds.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

constexpr int kUsualCrowd = 50;
constexpr int kUsualStops = 60;
constexpr double kUsualSettled = 20;
/// In a larger one each process has as much more to meet, and the processors are few.
constexpr double kSettledPerComponent = 0.4;
constexpr double kIdle = 5;

int& crowd_size() {
  static int size = kUsualCrowd;
  return size;
}

/// Reaches the processes of the crowd.
constexpr const char* kLeaseVariable = "RUBICON_BENCH_LEASE";

/// Seconds until all should see all, at least.
double& settled_seconds() {
  static double seconds = kUsualSettled;
  return seconds;
}

int& stops_seconds() {
  static int seconds = kUsualStops;
  return seconds;
}

std::vector<double> each(const std::vector<Json>& crowd, const char* name) {
  std::vector<double> values;
  for (const auto& one : crowd) values.push_back(one.at(name));
  return values;
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

int losses_of(const std::vector<Json>& crowd) {
  int lost = 0;
  for (const auto& one : crowd) lost += one.at("lost_peers").get<int>();
  return lost;
}

/// A crowd of bare processes: what the system takes to start them and to connect each with each.
Json bare_crowd(const Meeting& meeting, int count, double stay) {
  const auto begin = wall_seconds();
  std::vector<Child> children;
  for (int i = 0; i < count; ++i)
    children.push_back(
        start_role("bare-member", meeting, {{"number", i}, {"count", count}, {"begin", begin}, {"stay_s", stay}}));
  const auto crowd = results_of(children);
  return {{"seen_s", rounded(slowest_of(crowd), 2)}, {"cpu_s", rounded(sum_of(each(crowd, "meeting_cpu_s")), 2)}};
}

}  // namespace

double& lease_seconds() {
  static double seconds = 2;
  return seconds;
}

void add_crowd_options(CLI::App& app) {
  app.add_option("--lease", lease_seconds(), "seconds of silence after which a component on DDS is lost")
      ->envname(kLeaseVariable)
      ->check(CLI::Range(0.5, 60.0))
      ->each([](const std::string& seconds) { ::setenv(kLeaseVariable, seconds.c_str(), 1); })
      ->capture_default_str();
  app.add_option("--crowd", crowd_size(), "components of the crowd; DDS has 120 on a host")
      ->check(CLI::Range(2, 500))
      ->capture_default_str();
  app.add_option("--settled", settled_seconds(),
                 "seconds for all to see all, at least; 0.4 for each component if that is more")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--stops", stops_seconds(), "seconds of the measurement stops")
      ->check(CLI::Range(2, 86'400))
      ->capture_default_str();
}

void measure_crowd(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 10 : crowd_size();
  const CrowdTimes times{std::max(settled_seconds(), kSettledPerComponent * count), kIdle};
  const auto bare = bare_crowd(plan.new_meeting(), count, plan.is_quick ? 2 : kUsualSettled);
  auto children = start_crowd(plan.new_meeting(), count, plan.is_quick ? CrowdTimes{20, 1} : times);
  const auto crowd = results_of(children);
  const auto slowest = slowest_of(crowd);
  const auto idle = each(crowd, "idle_percent"), memory = each(crowd, "private_mb");
  const auto most = rounded(percentile(idle, 1), 2);
  const auto lost = losses_of(crowd);
  report.figure("all_see_all_s", slowest > 0 ? Json(rounded(slowest, 2)) : Json(nullptr));
  report.figure("bare_all_connected_s", bare.at("seen_s"));
  report.figure("idle_cpu_percent", rounded(median(idle), 3));
  report.figure("crowd_private_mb", rounded(median(memory), 2));
  report.figure("crowd_lost", lost);
  report.target("all_see_all_s", "under 10", slowest > 0 && slowest < 10);
  report.target("idle_cpu_percent", "under 1 each", most < 1);
  report.target("crowd_lost", "0", lost == 0);
  report.detail("all_see_all_s", {{"components", count},
                                  {"lease_s", plan.engine == "host" ? Json(nullptr) : Json(lease_seconds())},
                                  {"last_begun_s", rounded(percentile(each(crowd, "begun_s"), 1), 2)},
                                  {"processor_s", rounded(sum_of(each(crowd, "meeting_cpu_s")), 2)},
                                  {"bare_processor_s", bare.at("cpu_s")},
                                  {"idle_cpu_percent_most", most},
                                  {"private_mb_most", rounded(percentile(memory, 1), 2)},
                                  {"resident_mb", rounded(median(each(crowd, "resident_mb")), 2)}});
}

/// Each second one component is stopped or continued. Its stops are shorter than a lease, so the others must not count
/// it as lost, nor it them. On a busy machine `longest_stop_s` says whether the stops were that short.
void measure_stops(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 10 : crowd_size();
  const int seconds = plan.is_quick ? 4 : stops_seconds();
  const CrowdTimes times{plan.is_quick ? 4 : std::max(settled_seconds(), kSettledPerComponent * count), seconds + 2.0,
                         true};
  const auto begin = std::chrono::steady_clock::now() + std::chrono::duration<double>(times.settled);
  auto children = start_crowd(plan.new_meeting(), count, times);
  auto stopped = Clock::time_point();
  double longest = 0;
  for (int second = 0; second < seconds / 2 * 2; ++second) {
    std::this_thread::sleep_until(begin + std::chrono::seconds(second));
    const bool stops = second % 2 == 0;
    children.front().signal(stops ? SIGSTOP : SIGCONT);
    if (stops) stopped = Clock::now();
    if (!stops) longest = std::max(longest, seconds_since(stopped));
  }
  const auto crowd = results_of(children);
  const auto lost = losses_of(crowd);
  report.figure("stops_lost", lost);
  report.target("stops_lost", "0", lost == 0);
  report.detail("stops_lost", {{"components", count},
                               {"seconds", seconds},
                               {"longest_stop_s", rounded(longest, 2)},
                               {"cpu_percent", rounded(median(each(crowd, "idle_percent")), 3)}});
}

}  // namespace rubicon::bench
