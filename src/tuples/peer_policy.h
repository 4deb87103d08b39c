#pragma once

#include <map>
#include <memory>
#include <set>

#include "base/log.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/judge.h"
#include "tuples/link.h"

namespace rubicon::tuples {

/// Decides who a peer is and what it may do. A link has one and reports peers that come up and go down; the space asks
/// it when a distant subscription begins or joins a tuple and before each remote set, never per publication.
class PeerPolicy {
 public:
  virtual ~PeerPolicy() = default;
  /// Whether to accept this peer as that component; the error says why not. Asked before the peer is met, but not in
  /// the folder of a host, where the kernel has decided (docs/life-of-a-frame.md).
  virtual Result<void> may_join(const PeerIdentity& peer) = 0;
  /// A component that may join is up and has this id until peer_down(). Called again: it is another member now.
  virtual void peer_up(const PeerIdentity& peer) = 0;
  virtual void peer_down(OwnerId peer) = 0;
  /// Whether own tuples may answer this subscription of a component that is up.
  virtual Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) = 0;
  /// Whether a component that is up may request this set. The error goes into the reply.
  virtual Result<void> may_set(const RemoteSet& set) = 0;
  /// Whether a component that is up may send messages there, as Judge::may_send().
  virtual Result<void> may_send(OwnerId peer, std::string_view where) = 0;
  /// A set got its reply: the policy refused it, or the owner decided it.
  virtual void answered(const RemoteSet& set, const Reply& reply) = 0;
  /// The member that the component is; nullptr: it is not up, or the engine does not know. Valid until peer_down() or
  /// the next peer_up(), so use it in the present turn only.
  virtual const Member* member(OwnerId peer) const = 0;
  /// The member that is judged for a set: its sender, or the member that the sender names and may vouch for. nullptr:
  /// the process itself, or the engine does not know. Valid until the next call, and at most until peer_down().
  virtual const Member* asker(const RemoteSet& set) = 0;
  /// The host of a component that is up, as it declares it; empty: not up, or not known. Valid until peer_down().
  virtual std::string_view host(OwnerId peer) const = 0;
  /// The judge of what members may do; nullptr: none.
  virtual Judge* judge() = 0;
  /// Whether subscriptions of the component are judged for each own tuple they cover, by access().
  virtual bool filters(OwnerId peer) const = 0;
  /// What a subscription of the component receives from an own tuple. Only asked where filters() is true.
  virtual Access access(OwnerId peer, std::string_view key) const = 0;
};

/// Allows everything: for links inside one process.
class OpenPolicy : public PeerPolicy {
 public:
  Result<void> may_join(const PeerIdentity&) override { return {}; }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet&) override { return {}; }
  Result<void> may_send(OwnerId, std::string_view) override { return {}; }
  void answered(const RemoteSet&, const Reply&) override {}
  const Member* member(OwnerId) const override { return nullptr; }
  const Member* asker(const RemoteSet&) override { return nullptr; }
  std::string_view host(OwnerId) const override { return {}; }
  Judge* judge() override { return nullptr; }
  bool filters(OwnerId) const override { return false; }
  Access access(OwnerId, std::string_view) const override { return {}; }
};

/// The policy without authentication (docs/ecology.md): all components may read, and only those on this host may set,
/// unless `tuples.trust_lan` is on. A component declares its host itself, so this prevents mistakes, not attacks.
class DeclaredHostPolicy final : public PeerPolicy {
 public:
  DeclaredHostPolicy(OwnerId self, std::string own_host, bool trusts_others, Log log)
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
  std::map<OwnerId, std::string> hosts_;  ///< of the components that are up
  std::set<OwnerId> refusal_logged_;      ///< components that are up
};

/// The policy of a link that knows who its peers are: remembers the member of each component that is up, and asks the
/// judge of the process what that member may do. Components of the own process may do everything.
class MemberPolicy final : public PeerPolicy {
 public:
  /// `link_itself`: the member for which kLinkItself subscribes; null = none, and the link receives no own tuples.
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

/// What the rooms of the daemon need of a space, above all those that decide; not for other programs.
struct SpaceRights {
  /// The tuple is set soon: its memory comes into the cache meanwhile. It may be gone already.
  static void fetch(const TupleSpace& space, TupleRef tuple);
  /// Link::seeks().
  static bool seeks(TupleSpace& space, std::optional<OwnerId> owner);
  /// Asks the policy of the link again what the standing subscriptions of others get, over several turns if the tuples
  /// are many: a subscriber loses tuples that it may no longer read, and receives those that it may read from now on.
  static void rejudge(TupleSpace& space);
  /// How many changes may wait for each subscriber of another component; for tests.
  static void limit_queues(TupleSpace& space, std::size_t most);
  /// Who a component is, and what it may do.
  static PeerPolicy& policy(TupleSpace& space);
  /// nullptr: there are no rights here; every accepted component may do everything.
  static Judge* judge(TupleSpace& space) { return policy(space).judge(); }
  /// nullptr: it is not up, is of this process, or the engine does not know.
  static const Member* member_of(TupleSpace& space, OwnerId peer) { return policy(space).member(peer); }
  /// The member that asks for a set; nullptr: this process itself, or the engine does not know.
  static const Member* asker(TupleSpace& space, const RemoteSet& set);
};

}  // namespace rubicon::tuples
