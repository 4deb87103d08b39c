// Measures networks/zigbee: rubicon-bench-zigbee prints one JSON object (docs/benchmarks.md, "ZigBee").
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>

#include "zigbee/measurements.h"

namespace rubicon::bench::zigbee {

double percentile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(static_cast<double>(values.size() - 1) * part))];
}

double median(std::vector<double> values) {
  return percentile(std::move(values), 0.5);
}

double milliseconds(Clock::duration span) {
  return std::chrono::duration<double, std::milli>(span).count();
}

double rounded(double value, int digits) {
  const double by = std::pow(10, digits);
  return std::round(value * by) / by;
}

}  // namespace rubicon::bench::zigbee

int main(int argc, char** argv) {
  using namespace rubicon::bench::zigbee;
  using namespace std::chrono_literals;
  const std::pair<const char*, void (*)(const Plan&, Json&)> all[] = {{"lists", measure_lists},
                                                                      {"states", measure_states},
                                                                      {"traffic", measure_traffic},
                                                                      {"commands", measure_commands},
                                                                      {"restarts", measure_restarts}};
  CLI::App app("Measures the ZigBee network beside a real broker", "rubicon-bench-zigbee");
  bool quick = false;
  std::vector<std::string> only, names;
  for (const auto& one : all) names.emplace_back(one.first);
  app.add_flag("--quick", quick, "a short run that checks the measurements without meaningful figures");
  app.add_option("--only", only, "lists, states, traffic, commands or restarts (may be repeated)")
      ->check(CLI::IsMember(names))
      ->allow_extra_args(false);
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGPIPE, SIG_IGN);
  if (::geteuid() != 0) ::unshare(CLONE_NEWUSER);  // a private network of one's own is then allowed
  Plan plan;
  if (quick) plan = {1, 30, 60, 2000, 3s, 40, 2};
  Json out;
  for (const auto& [name, measure] : all) {
    if (only.empty() || std::find(only.begin(), only.end(), name) != only.end()) measure(plan, out);
  }
  fmt::print("{}\n", out.dump(2));
  return 0;
}
