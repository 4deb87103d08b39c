#pragma once

#include <functional>

#include "tuples/peer_policy.h"

namespace rubicon::tuples::joined {

/// Asks the policy of the engine that brought the question. The engines inform their own policies of who is there.
class JoinedPolicy final : public PeerPolicy {
 public:
  /// The policy of the engine that speaks for the peer at the moment; nullptr: no engine does.
  using Find = std::function<PeerPolicy*(OwnerId peer)>;
  explicit JoinedPolicy(Find find) : find_(std::move(find)) {}

  Result<void> may_join(const PeerIdentity& peer) override {
    auto* policy = find_(peer.id);
    return policy ? policy->may_join(peer) : absent(peer.id);
  }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) override {
    if (peer == kLinkItself) return {};
    auto* policy = find_(peer);
    return policy ? policy->may_subscribe(peer, spec) : absent(peer);
  }
  Result<void> may_set(const RemoteSet& set) override {
    auto* policy = find_(set.from);
    return policy ? policy->may_set(set) : absent(set.from);
  }

 private:
  static Result<void> absent(OwnerId peer) {
    return fail(ErrorCode::kNotFound, "component " + std::to_string(number(peer)) + " is not present");
  }

  Find find_;
};

}  // namespace rubicon::tuples::joined
