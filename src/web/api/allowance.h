#pragma once

#include <algorithm>

#include "rubicon/time.hpp"

namespace rubicon::web::api {

/// How often something is allowed: so many times in each second, which may come at once.
class Allowance {
 public:
  explicit Allowance(unsigned per_second) : most_(per_second), left_(per_second) {}

  /// False: not now.
  bool take(SteadyTime now) {
    if (now > last_) {
      left_ = std::min(most_, left_ + most_ * std::chrono::duration<double>(now - last_).count());
      last_ = now;
    }
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }
  /// Something cost more than was known when it was allowed: the next ones wait.
  void charge(double more) { left_ -= more; }
  /// As without use.
  bool is_full(SteadyTime now) const {
    return left_ + most_ * std::chrono::duration<double>(now - last_).count() >= most_;
  }

 private:
  double most_, left_;
  SteadyTime last_{};
};

}  // namespace rubicon::web::api
