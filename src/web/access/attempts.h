#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::web::access {

/// Counts wrong tokens: after 5 in a minute an address waits. IPv6 addresses count by their network of 64 bits, which
/// is what one host gets. Bounded: beyond 1024 addresses all new ones share one count.
class Attempts {
 public:
  static constexpr std::size_t kMost = 5;
  static constexpr std::size_t kMostAddresses = 1024;
  static constexpr Duration kPeriod = std::chrono::minutes(1);

  bool may_try(const std::string& address, SteadyTime now);
  void failed(const std::string& address, SteadyTime now);
  std::size_t addresses() const { return failures_.size(); }

 private:
  std::string subject(const std::string& address) const;
  void forget(SteadyTime now);

  std::map<std::string, std::deque<SteadyTime>> failures_;
};

}  // namespace rubicon::web::access
