#pragma once

#include <map>
#include <set>

#include "base/log.h"
#include "tuples/peer_policy.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples {

/// The policy without authentication (docs/ecology.md): all components may read, and only those on this host may set,
/// unless `tuples.trust_lan` is on. A component declares its host itself, so this prevents mistakes, not attacks.
class HostPolicy final : public PeerPolicy {
 public:
  HostPolicy(OwnerId self, std::string own_host, bool trusts_others, Log log)
      : self_(self), own_host_(std::move(own_host)), trusts_others_(trusts_others), log_(std::move(log)) {}

  /// Earlier starts are rejected: 2000-01-01 UTC.
  static constexpr std::uint64_t kEarliest = 946'684'800'000'000;

  /// The error that others would find in a component that starts now.
  static Result<void> check_clock(WallTime now);

  /// Whether the start that a component declares is a plausible time. Engines ask whose starts are times.
  static Result<void> check_start(OwnerId peer, std::uint64_t incarnation);

  Result<void> may_join(const PeerIdentity&) override { return {}; }
  /// A stand-in counts as the component that it stands for.
  void peer_up(const PeerIdentity& peer) override { hosts_[peer.id] = real_host(peer.host); }
  void peer_down(OwnerId peer) override;
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet& set) override;
  /// Messages arrive as remote sets, which may_set() decided.
  Result<void> may_send(OwnerId, std::string_view) override { return {}; }
  void answered(const RemoteSet&, const Reply&) override {}
  const Member* member(OwnerId) const override { return nullptr; }
  const Member* asker(const RemoteSet&) override { return nullptr; }
  std::string_view host(OwnerId peer) const override;
  Judge* judge() override { return nullptr; }
  bool filters(OwnerId) const override { return false; }
  Access access(OwnerId, std::string_view) const override { return {}; }

 private:
  OwnerId self_;
  std::string own_host_;
  bool trusts_others_;
  Log log_;
  std::map<OwnerId, std::string> hosts_;  ///< of those that are up
  std::set<OwnerId> refusal_logged_;      ///< of those that are up
};

}  // namespace rubicon::tuples
