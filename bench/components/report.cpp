#include "components/report.h"

#include <fmt/format.h>
#include <unistd.h>

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

Meeting Plan::new_meeting() const {
  static int count = 0;
  return {domain, fmt::format("bench-{}-{}", ::getpid(), ++count), engine};
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
