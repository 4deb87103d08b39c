#pragma once

#include <chrono>
#include <vector>

#include "components/node.h"

namespace rubicon::bench {

/// Half round trips in windows of a second, as ddsperf reports them; the first window warms up and does not count.
class Windows {
 public:
  void begin(SteadyTime now) { begin_ = now; }
  void add(SteadyTime sent, SteadyTime now) {
    const auto window = static_cast<std::size_t>(seconds_between(begin_, now));
    if (windows_.size() <= window) windows_.resize(window + 1);
    windows_[window].push_back(std::chrono::duration<double, std::micro>(now - sent).count() / 2);
  }
  double seconds(SteadyTime now) const { return seconds_between(begin_, now); }

  Json json() const {
    std::vector<double> p50, p99;
    for (std::size_t i = 1; i + 1 < windows_.size() || (i == 1 && i < windows_.size()); ++i) {
      p50.push_back(percentile(windows_[i], 0.5));
      p99.push_back(percentile(windows_[i], 0.99));
    }
    return {{"p50", median(p50)}, {"p99", median(p99)}, {"p50_of_seconds", p50}};
  }

 private:
  SteadyTime begin_{};
  std::vector<std::vector<double>> windows_;
};

}  // namespace rubicon::bench
