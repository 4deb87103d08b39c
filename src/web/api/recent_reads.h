#pragma once

#include <map>
#include <string>

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// Keeps the copies of tuples that were read lately: a client that asks again soon, or for the next page, need not wait
/// until all owners sent them again.
class RecentReads {
 public:
  static constexpr Duration kTime = std::chrono::seconds(60);

  RecentReads(Scheduler& scheduler, TupleSpace& space) : scheduler_(scheduler), space_(space) {}

  /// Until kTime after the last call with the same pattern. Not for patterns that a client chooses: they are not
  /// bounded.
  void keep(const Pattern& pattern);

 private:
  struct Kept {
    tuples::Handle subscription;
    Timer end;
  };

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::map<std::string, Kept> kept_;
};

}  // namespace rubicon::web::api
