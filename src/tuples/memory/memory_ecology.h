#pragma once

#include <memory>

#include "base/scheduler.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples {

/// An ecology inside one process and one loop: each link is a component that reaches all others. Tests use it in place
/// of the distributed engine, because connections can be cut.
class MemoryEcology final : public StandInEcology {
 public:
  /// `host`: PeerIdentity::host of all members.
  explicit MemoryEcology(Scheduler& scheduler, std::string host = "memory");
  ~MemoryEcology() override;

  /// kDuplicate if the id is present. Destroying the link = leaving.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  /// `displaced` is not used: no two members have one id.
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// Cuts the connection of two components: each loses the other, and what is under way is lost.
  void cut(OwnerId a, OwnerId b);
  /// Restores it.
  void mend(OwnerId a, OwnerId b);

 private:
  class MemoryLink;
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples
