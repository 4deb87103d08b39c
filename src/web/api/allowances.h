#pragma once

#include <map>
#include <string>

#include "web/api/allowance.h"

namespace rubicon::web::api {

/// An Allowance for each caller. Bounded: callers whose allowance is full are forgotten, and beyond kMost new
/// ones share one allowance.
class Allowances {
 public:
  explicit Allowances(unsigned per_second) : per_second_(per_second), shared_(per_second) {}

  bool take(const std::string& caller, SteadyTime now) { return of(caller, now).take(now); }
  /// See Allowance::charge().
  void charge(const std::string& caller, SteadyTime now, double more) { of(caller, now).charge(more); }

 private:
  Allowance& of(const std::string& caller, SteadyTime now) {
    const auto known = callers_.find(caller);
    if (known != callers_.end()) return known->second;
    if (callers_.size() >= kMost) std::erase_if(callers_, [now](const auto& one) { return one.second.is_full(now); });
    if (callers_.size() >= kMost) return shared_;
    return callers_.emplace(caller, Allowance(per_second_)).first->second;
  }

  static constexpr std::size_t kMost = 1024;

  unsigned per_second_;
  Allowance shared_;
  std::map<std::string, Allowance> callers_;
};

}  // namespace rubicon::web::api
