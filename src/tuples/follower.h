#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tuples/meta_tuple.h"

namespace rubicon::tuples {

/// Follows one reference: returns the name that the last tuple of `chain` holds, or nullopt if that tuple is the
/// target. Errors as for resolve(). The chain begins with the first meta tuple.
Result<std::optional<TupleName>> next_reference(const TupleSpace& space, std::span<const TupleName> chain);

/// Implements subscribe_through(). It evaluates the present tuples instead of single events, so that a thousand changes
/// in a turn cost one move, and a cycle costs nothing until one of its tuples changes. Owned by the Handle, and by a
/// call of the space while it runs.
class Follower : public std::enable_shared_from_this<Follower> {
 public:
  Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call);

  void begin(const TupleName& meta);
  /// No call follows.
  void end();

 private:
  enum class Role { kNone, kReference, kTarget };
  /// The subscription to one tuple of the chain.
  struct Hop {
    Role role = Role::kNone;
    Handle subscription;
  };

  void watch(std::size_t position, Role role);
  using Hops = std::vector<Hop>;
  Hops cut(std::size_t count);
  void on_event(std::size_t position, const Event& event);
  void follow(std::size_t at);
  void forward(const Event& event);
  void report_removed(EventKind how);
  void report_target(Result<TupleName> target);

  TupleSpace& space_;
  Flow flow_;
  EventCall call_;
  TargetCall target_call_;
  std::vector<TupleName> chain_;
  Hops hops_;                                // one for each name of the chain
  std::optional<TupleName> delivered_;       // whose value was delivered, and not reported as removed
  std::optional<Result<TupleName>> target_;  // as reported
  bool ended_ = false;
};

}  // namespace rubicon::tuples
