#include "frame/process_figures.h"

#include <fmt/format.h>
#include <malloc.h>
#include <time.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace rubicon::bench {

namespace {

/// A line `VmRSS:  1234 kB` of a file about this process.
double mb_in(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name)) return std::stod(line.substr(name.size() + 1)) * 1.024 / 1000;
  }
  return 0;
}

}  // namespace

double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

double processor_seconds(pid_t pid) {
  double nanoseconds = 0;
  for (const auto& thread : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid))) {
    double one = 0;
    std::ifstream(thread.path() / "schedstat") >> one;
    nanoseconds += one;
  }
  return nanoseconds * 1e-9;
}

double resident_mb() {
  return mb_in("/proc/self/status", "VmRSS");
}

double private_mb() {
  return mb_in("/proc/self/smaps_rollup", "Private_Dirty");
}

double peak_mb() {
  return mb_in("/proc/self/status", "VmHWM");
}

void forget_peak() {
  ::malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace rubicon::bench
