#pragma once

#include <map>
#include <set>

#include "base/log.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

/// The policy without authentication (docs/ecology.md): a start is a time of a clock that was set, everybody may read,
/// and only components of the own host may set unless `tuples.trust_lan` says otherwise. Peers say themselves where
/// they run: this keeps out mistakes, not liars.
class HostPolicy final : public PeerPolicy {
 public:
  HostPolicy(OwnerId self, std::string own_host, bool trusts_others, Log log)
      : self_(self), own_host_(std::move(own_host)), trusts_others_(trusts_others), log_(std::move(log)) {}

  /// Starts before this are no times: 2000-01-01 UTC.
  static constexpr std::uint64_t kEarliest = 946'684'800'000'000;

  Result<void> may_join(const PeerIdentity& peer) override;
  void peer_up(const PeerIdentity& peer) override { hosts_[peer.id] = peer.host; }
  void peer_down(OwnerId peer) override;
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet& set) override;

 private:
  OwnerId self_;
  std::string own_host_;
  bool trusts_others_;
  Log log_;
  std::map<OwnerId, std::string> hosts_;  ///< of those that are up
  std::set<OwnerId> named_;               ///< of those that are up: whose refusal stands in the log
};

}  // namespace rubicon::tuples::dds
