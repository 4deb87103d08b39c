#pragma once

#include <memory>

#include "base/scheduler.h"
#include "tuples/judge.h"
#include "tuples/link.h"

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

  /// From now on the component that joins with that id is this member; others are of the own process.
  void certify(OwnerId id, Member who);
  /// From now on the component that joins with that id asks this judge what members may; without one, everything.
  void judge(OwnerId id, std::shared_ptr<Judge> judge);

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
