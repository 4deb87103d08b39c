#pragma once

#include <memory>

#include "base/scheduler.h"
#include "tuples/link.h"

namespace rubicon::tuples {

/// An ecology inside one process and one loop: every link it makes is a component that reaches all others. Also the
/// twin of the distributed engine in tests: components can be cut off and crash.
class MemoryEcology final : public Ecology {
 public:
  explicit MemoryEcology(Scheduler& scheduler);
  ~MemoryEcology() override;

  /// kDuplicate if the id is present. Destroying the link = leaving.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;

  /// Nothing passes between the two until mended; each sees the other as lost. What was sent is lost with it.
  void cut(OwnerId a, OwnerId b);
  void mend(OwnerId a, OwnerId b);

 private:
  class MemoryLink;
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples
