// Measures networks/knx: rubicon-bench-knx prints one JSON object (docs/benchmarks.md, "KNX").
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <numeric>

#include "knx/measurements.h"

namespace rubicon::bench::knx {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace rubicon::bench::knx

int main(int argc, char** argv) {
  using namespace rubicon::bench::knx;
  CLI::App app("Measures the KNX network beside knxd and a bare loop");
  bool quick = false;
  std::vector<std::string> only;
  app.add_flag("--quick", quick, "small: shows that it works, not how fast");
  app.add_option("--only", only, "telegrams, loss, dpt or import (may be repeated)")
      ->check(CLI::IsMember({"telegrams", "loss", "dpt", "import"}))
      ->allow_extra_args(false);
  CLI11_PARSE(app, argc, argv);
  if (::geteuid() != 0) ::unshare(CLONE_NEWUSER);  // a private network of one's own is then allowed
  Plan plan;
  if (quick) plan = {1, 1000, 40, 100'000, 1000};
  Json out;
  const std::pair<const char*, void (*)(const Plan&, Json&)> all[] = {
      {"telegrams", measure_telegrams}, {"loss", measure_loss}, {"dpt", measure_dpt}, {"import", measure_import}};
  for (const auto& [name, measure] : all) {
    if (only.empty() || std::find(only.begin(), only.end(), name) != only.end()) measure(plan, out);
  }
  fmt::print("{}\n", out.dump(2));
  return 0;
}
