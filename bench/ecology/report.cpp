#include "ecology/report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>

namespace rubicon::bench {

namespace {

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

}  // namespace

double percentile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto last = static_cast<double>(values.size() - 1);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::lround(last * part));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  return percentile(std::move(values), 0.5);
}

double rounded(double value, int digits) {
  const auto scale = std::pow(10, digits);
  return std::round(value * scale) / scale;
}

Meeting Plan::new_meeting() const {
  static int count = 0;
  return {domain, fmt::format("bench-{}-{}", ::getpid(), ++count)};
}

Json Report::json() const {
  auto all = figures_;
  all["targets"] = targets_;
  all["details"] = details_;
  double load[3] = {};
  ::getloadavg(load, 3);
  all["machine"] = {{"processor", processor()},
                    {"cores", std::thread::hardware_concurrency()},
                    {"load", {rounded(load[0], 2), rounded(load[1], 2), rounded(load[2], 2)}}};
  return all;
}

}  // namespace rubicon::bench
