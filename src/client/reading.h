#pragma once

#include <memory>
#include <set>

#include "client/acquaintance.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// All present tuples that match, once: waits until every owner has told what it has. Ends when destroyed, without a
/// call.
class Reading {
 public:
  Reading(Scheduler& scheduler, TupleSpace& space, const Acquaintance& acquaintance, Pattern pattern, TuplesCall call,
          Duration patience);

 private:
  void check();
  bool complete() const;
  void end();

  Scheduler& scheduler_;
  TupleSpace& space_;
  const Acquaintance& acquaintance_;
  Pattern pattern_;
  TuplesCall call_;
  std::set<OwnerId> told_;
  bool over_ = false;
  tuples::Handle subscription_, peers_;
  Timer patience_, again_;
};

}  // namespace rubicon::client
