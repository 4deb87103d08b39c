#pragma once

#include <map>
#include <memory>

#include "tuples/judge.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples {

/// The policy of a link that knows who its peers are: remembers the member of each component that is up, and asks the
/// judge of the process what that member may. Components of the own process may do everything.
class MemberPolicy final : public PeerPolicy {
 public:
  /// `link_itself`: who stands behind kLinkItself; null = no member, then the link gets no own tuples for itself.
  MemberPolicy(OwnerId self, std::shared_ptr<Judge> judge, std::shared_ptr<const Member> link_itself = nullptr)
      : self_(self), judge_(std::move(judge)), link_itself_(std::move(link_itself)) {}

  /// kRefused: the engine does not know who it is, or that member does not have this id.
  Result<void> may_join(const PeerIdentity& peer) override;
  void peer_up(const PeerIdentity& peer) override;
  void peer_down(OwnerId peer) override { peers_.erase(peer); }
  Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) override;
  Result<void> may_set(const RemoteSet& set) override;
  Result<void> may_send(OwnerId peer, std::string_view where) override;
  void answered(const RemoteSet& set, const Reply& reply) override;
  const Member* member(OwnerId peer) const override;
  const Member* asker(const RemoteSet& set) override;
  std::string_view host(OwnerId peer) const override;
  Judge* judge() override { return judge_.get(); }
  bool filters(OwnerId peer) const override;
  Access access(OwnerId peer, std::string_view key) const override;

 private:
  struct Peer {
    std::shared_ptr<const Member> member;
    bool own_process = false;
    std::string host;
  };
  bool is_own(OwnerId peer) const;

  OwnerId self_;
  std::shared_ptr<Judge> judge_;
  std::shared_ptr<const Member> link_itself_;
  std::map<OwnerId, Peer> peers_;  ///< those that are up
  Member vouched_;                 ///< what asker() returned last
};

}  // namespace rubicon::tuples
