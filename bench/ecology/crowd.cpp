#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>

#include "ecology/report.h"
#include "ecology/roles.h"

namespace rubicon::bench {

namespace {

constexpr std::uint32_t kFirstOfMany = 71000;
constexpr double kSettled = 20, kIdle = 5;

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double processor_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

/// All components stay until the same time, so that no leaving is measured.
Json one_of_many(const Meeting& meeting, const Json& options) {
  const double begin = options.at("begin");
  const std::size_t others = options.at("count").get<std::size_t>() - 1;
  Node node(OwnerId(kFirstOfMany + options.at("number").get<std::uint32_t>()), meeting);
  double seen = 0;
  const auto watch = node.space().watch_peers([&](OwnerId, tuples::PeerEvent) {
    if (seen == 0 && node.space().peers().size() == others) seen = wall_seconds() - begin;
  });
  base::Timer timer;
  const auto until = [&](double when) {
    const auto left = std::chrono::duration<double>(std::max(0.0, begin + when - wall_seconds()));
    timer = node.scheduler().after(std::chrono::duration_cast<base::Duration>(left), [&] { node.finish(); });
    node.run(std::chrono::minutes(2));
  };
  until(kSettled);
  const auto used = processor_seconds(), since = wall_seconds();
  until(kSettled + kIdle);
  const auto percent = (processor_seconds() - used) / (wall_seconds() - since) * 100;
  until(kSettled + kIdle + 1);
  return {{"seen_s", seen}, {"idle_percent", percent}};
}

void measure_crowd(const Plan& plan, Report& report) {
  const int count = plan.is_quick ? 10 : 50;
  const auto meeting = plan.new_meeting();
  const auto begin = wall_seconds();
  std::vector<Child> all;
  all.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    all.push_back(start_role("one-of-many", meeting, {{"number", i}, {"count", count}, {"begin", begin}}));
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
