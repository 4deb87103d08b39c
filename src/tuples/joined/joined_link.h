#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include "base/deadline.h"
#include "base/limited_log.h"
#include "tuples/held_sets.h"
#include "tuples/joined/joined_policy.h"
#include "tuples/joined/met_peer.h"

namespace rubicon::tuples::joined {

/// One component on several engines: offers its tuples, subscriptions and summary on all of them, and sends to each
/// other component by the engine where that one lives. When it moves to another engine, the listener receives kLost and
/// kUp, so that both sides start again with a snapshot.
class JoinedLink final : public Link {
 public:
  /// Subscriptions of one component on one engine; more are ignored.
  static constexpr std::size_t kMaxSubscriptions = 10'000;
  /// Two components with one id may be one that changes: its restart, or the first contact. Afterwards it is an error.
  static constexpr Duration kContactTime = std::chrono::seconds(5), kRestartTime = std::chrono::seconds(60);
  /// A remote set to a stand-in waits until it was met for this time: another engine may meet the component itself.
  static constexpr Duration kSearchTime = std::chrono::seconds(2);

  struct Engine {
    std::string name;
    std::unique_ptr<Link> link;
  };
  JoinedLink(OwnerId self, std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log,
             std::string own_host = {});
  ~JoinedLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  bool seeks(OwnerId id) override;
  void describe(std::string summary) override;
  void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const override;
  PeerPolicy& policy() override { return policy_; }

 private:
  class Port;
  /// A request that is being decided, which its engine brought.
  struct Arriving {
    std::size_t engine = 0;
    OwnerId from{};
  };

  void on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event);
  void on_summary(std::size_t engine, OwnerId id, std::string_view summary);
  void on_changes(std::size_t engine, OwnerId owner, std::span<const Change> changes);
  void on_subscribe(std::size_t engine, OwnerId id, const SubscriptionSpec& spec);
  void on_unsubscribe(std::size_t engine, OwnerId id, std::uint32_t subscription);
  void on_remote_set(std::size_t engine, const RemoteSet& set);
  bool on_reply(std::size_t engine, OwnerId from, const Reply& reply);
  void refuse(std::size_t engine, const RemoteSet& set);

  void meet(std::size_t engine, const PeerIdentity& who);
  void part(std::size_t engine, OwnerId id, PeerEvent how);
  void report(OwnerId id, const MetPeer::Move& move);
  void ask_again(std::size_t engine);
  SteadyTime search_end(OwnerId owner) const;
  void release(OwnerId owner);
  void release_due();
  void watch_conflict(MetPeer& peer, OwnerId id, std::size_t engine);
  bool is_barred(std::size_t engine, const PeerIdentity& who) const;
  void log_barred(OwnerId id, std::size_t engine);
  void log_conflict(OwnerId id, std::size_t engine);
  std::string described(OwnerId id, std::size_t engine) const;

  MetPeer* find(OwnerId id);
  Meeting* find(OwnerId id, std::size_t engine);
  bool publish_to_observers(std::span<const Change> changes);
  Link* link_to(OwnerId id);
  PeerPolicy* any_policy();
  std::optional<std::size_t> home_of(OwnerId id) const;

  OwnerId self_;
  Scheduler& scheduler_;
  base::LimitedLog log_;
  std::string own_host_;
  std::vector<std::unique_ptr<Port>> ports_;
  JoinedPolicy policy_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::uint64_t attachment_ = 0;  ///< changes with the listener, which each call to it may detach
  std::map<OwnerId, MetPeer> peers_;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;  ///< own ones
  std::optional<Arriving> arriving_;
  HeldSets held_;
  base::Deadline next_held_{scheduler_, [this] { release_due(); }};
  std::set<std::size_t> observers_;  ///< engines whose links subscribed to own tuples for themselves
  std::set<std::tuple<OwnerId, std::uint64_t, std::uint64_t>> logged_;  ///< conflicts, by the starts of both sides
};

}  // namespace rubicon::tuples::joined
