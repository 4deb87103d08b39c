#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

#include "rubicon/time.hpp"

namespace rubicon::base {

/// Allows one log line per subject and minute, and counts the suppressed ones. Bounded: beyond 1024 subjects in
/// a minute all new ones share one limit.
class RateLimit {
 public:
  explicit RateLimit(Duration period = std::chrono::minutes(1)) : period_(period) {}

  bool allow(const std::string& subject, SteadyTime now);
  std::uint64_t swallowed() const { return swallowed_; }

 private:
  Duration period_;
  std::unordered_map<std::string, SteadyTime> last_;
  SteadyTime cleaned_{};
  std::uint64_t swallowed_ = 0;
};

}  // namespace rubicon::base
