#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tuples/meta_tuple.h"

namespace rubicon::tuples {

/// One step along the references: the name the last tuple of `chain` holds, nothing if that tuple is the end; errors as
/// resolve. The chain begins with the meta tuple it all started from.
Result<std::optional<TupleName>> next_reference(const TupleSpace& space, std::span<const TupleName> chain);

/// What stands behind subscribe_through. It looks at the tuples as they are now, not at single events, so that a
/// thousand changes in a turn cost one move, and a cycle costs nothing until one of its tuples changes. Owned by the
/// Handle, and by the space's call while that lasts.
class Follower : public std::enable_shared_from_this<Follower> {
 public:
  Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call);

  void begin(const TupleName& meta);
  /// No call is made after it.
  void end();

 private:
  enum class Role { kNone, kReference, kTarget };
  /// One tuple on the way, and its subscription.
  struct Stop {
    Role role = Role::kNone;
    Handle subscription;
  };

  void watch(std::size_t place, Role role);
  using Stops = std::vector<Stop>;
  Stops cut(std::size_t count);
  void on_event(std::size_t place, const Event& event);
  void follow(std::size_t at);
  void pass_on(const Event& event);
  void tell_gone(EventKind how);
  void tell_target(Result<TupleName> target);

  TupleSpace& space_;
  Flow flow_;
  EventCall call_;
  TargetCall target_call_;
  std::vector<TupleName> chain_;
  Stops stops_;                              // one for each name of the chain
  std::optional<TupleName> standing_;        // whose value was told and not taken back
  std::optional<Result<TupleName>> target_;  // as told
  bool ended_ = false;
};

}  // namespace rubicon::tuples
