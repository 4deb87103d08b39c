#pragma once

#include "base/log.h"
#include "base/virtual_scheduler.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::tuples::joined {

/// Components that meet on two engines in memory. They are cut from each other on both.
class JoinedTestEcology {
 public:
  explicit JoinedTestEcology(VirtualScheduler& time) : first_(time), second_(time), joined_(engines(), time, log_) {}

  Result<std::unique_ptr<Link>> join(OwnerId id) { return joined_.join(id); }
  void cut(OwnerId a, OwnerId b) {
    second_.cut(a, b);
    first_.cut(a, b);
  }
  void mend(OwnerId a, OwnerId b) {
    first_.mend(a, b);
    second_.mend(a, b);
  }

 private:
  std::vector<JoinedEcology::Engine> engines() { return {{"first", first_}, {"second", second_}}; }

  base::NullLogSink log_;
  MemoryEcology first_, second_;
  JoinedEcology joined_;
};

}  // namespace rubicon::tuples::joined
