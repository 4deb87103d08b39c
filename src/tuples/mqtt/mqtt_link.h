#pragma once

#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tuples/mqtt/channel.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::mqtt {

/// The link of one component: has a channel to each other component that it exchanged something with.
class MqttLink final : public Link {
 public:
  MqttLink(MqttEcology& ecology, StandIn who);
  ~MqttLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  bool seeks(std::optional<OwnerId> id) override;
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return *policy_; }
  void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const override;

  // For the ecology. Each may detach the link, or destroy it.
  OwnerId id() const { return who_.id; }
  bool attached() const { return listener_ != nullptr; }
  std::uint64_t incarnation() const { return incarnation_; }
  bool is_stand_in() const { return carrier_of(who_.host) != model::kNoOwner; }
  ComponentShown shown() const { return {incarnation_, who_.host, summary_}; }
  /// The id may now belong to another component, or to none.
  void review(OwnerId id, PeerEvent how);
  /// Components that are up may have other rights now; the space has to ask again.
  void judge_again();
  /// The component that counts as the sender.
  void arrived(const FrameHead& head, ByteView entries);
  void flush();
  void reconnected();
  /// Components that owe an acknowledgement for longer than this.
  std::vector<OwnerId> silent(Duration patience) const;
  void displace();
  void too_large(OwnerId peer, std::uint64_t stream, std::uint64_t number);
  std::size_t channels() const;

 private:
  class Reader;
  struct Held {
    RemoteSet set;
    Duration sent;
    SteadyTime since;
  };
  /// One that is up, or was.
  struct Peer {
    PeerIdentity identity;
    std::shared_ptr<const Reached> at;  ///< null: it is not up
    SteadyTime moved{};                 ///< to another connection, last
    std::unique_ptr<Channel> channel;   ///< null: nothing was exchanged since it is up
    bool dealt = false;                 ///< something was exchanged with this start
    std::uint64_t last_request = 0;     ///< highest number of its requests
    std::list<Held> held;               ///< requests whose age is not known yet
    std::size_t held_bytes = 0;
  };

  // the entries of the present frame
  void on_changes(std::span<const Change> changes);
  void on_set(RemoteSet&& set);
  void on_reply(Reply&& reply);
  void on_times(const distant::FrameTimes& times);
  void on_subscription(SubscriptionSpec&& spec);
  void on_unsubscription(std::uint32_t id);

  void introduce();
  void peer_up(OwnerId id, const std::shared_ptr<const Reached>& reached);
  void peer_down(OwnerId id, PeerEvent how);
  PeerIdentity identity_of(OwnerId id, const Reached& reached) const;
  PeerIdentity as_judged(PeerIdentity identity) const;
  void moved(Peer& peer);
  Channel& channel(Peer& peer);
  Channel::Callbacks channel_calls(OwnerId id);
  void give_up(OwnerId peer, ByteView entries);
  void exceeds(OwnerId peer, std::string_view key, std::size_t size);
  void send_interests(Peer& peer);
  void send_interest(Peer& peer, const SubscriptionSpec& spec);
  void received(OwnerId id, ByteView entries);
  Peer* find_up(OwnerId id);
  void take_set(Peer& peer, RemoteSet&& set, std::optional<Duration> sent);
  void take_held(OwnerId id);
  void look_at_held();
  void refuse(const RemoteSet& set, const Error& why);
  void forget_gone();

  MqttEcology& ecology_;
  StandIn who_;
  std::unique_ptr<PeerPolicy> policy_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  bool introduced_ = false;  ///< the listener knows who was there when it was attached
  bool displaced_ = false;
  std::string summary_;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;
  std::map<OwnerId, Peer> peers_;
  OwnerId reading_from_{};
  std::optional<Duration> reading_sent_;
  std::size_t held_bytes_ = 0;  ///< of all peers
  Timer held_timer_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::mqtt
