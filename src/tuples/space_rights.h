#pragma once

#include "rubicon/tuple_space.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::tuples {

/// What the parts of a process that decide need of a space; not for other programs.
struct SpaceRights {
  /// Asks the policy of the link again what the standing subscriptions of others get, over several turns if the tuples
  /// are many: a subscriber loses tuples that it may no longer read, and receives those that it may read from now on.
  static void rejudge(TupleSpace& space);
  /// How many changes may wait for each subscriber of another component; for tests.
  static void limit_queues(TupleSpace& space, std::size_t most);
  /// Who a component is, and what it may.
  static PeerPolicy& policy(TupleSpace& space);
  /// nullptr: there are no rights here, whoever is accepted may do everything.
  static Judge* judge(TupleSpace& space) { return policy(space).judge(); }
  /// nullptr: it is not up, is of this process, or the engine does not know.
  static const Member* member_of(TupleSpace& space, OwnerId peer) { return policy(space).member(peer); }
  /// Who asks for a set: nullptr: this process itself, or the engine does not know.
  static const Member* asker(TupleSpace& space, const RemoteSet& set);
};

}  // namespace rubicon::tuples
