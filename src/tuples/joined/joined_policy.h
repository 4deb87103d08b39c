#pragma once

#include <functional>

#include "tuples/peer_policy.h"

namespace rubicon::tuples::joined {

/// Asks the policy of the engine that brought the question. The engines inform their own policies of who is there.
class JoinedPolicy final : public PeerPolicy {
 public:
  /// The policy of the engine that speaks for the peer at the moment, for kLinkItself of one that observes own tuples,
  /// for kNoOwner of any, if possible one with a judge; nullptr: no engine does.
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
  Result<void> may_send(OwnerId peer, std::string_view where) override {
    auto* policy = find_(peer);
    return policy ? policy->may_send(peer, where) : absent(peer);
  }
  void answered(const RemoteSet& set, const Reply& reply) override {
    if (auto* policy = find_(set.from)) policy->answered(set, reply);
  }
  const Member* member(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy ? policy->member(peer) : nullptr;
  }
  const Member* asker(const RemoteSet& set) override {
    auto* policy = find_(set.from);
    return policy ? policy->asker(set) : nullptr;
  }
  std::string_view host(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy ? policy->host(peer) : std::string_view();
  }
  /// All engines of a process ask the same.
  Judge* judge() override {
    auto* policy = find_(model::kNoOwner);
    return policy ? policy->judge() : nullptr;
  }
  bool filters(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy && policy->filters(peer);
  }
  Access access(OwnerId peer, std::string_view key) const override {
    const auto* policy = find_(peer);
    return policy ? policy->access(peer, key) : Access{false, false, Duration(0)};
  }

 private:
  static Result<void> absent(OwnerId peer) {
    return fail(ErrorCode::kNotFound, "component " + std::to_string(number(peer)) + " is not present");
  }

  Find find_;
};

}  // namespace rubicon::tuples::joined
