#pragma once

#include <map>
#include <memory>
#include <string>

#include "tuples/peer_policy.h"
#include "tuples/peis/kernel_session.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::peis {

/// One start of a component, from attach() to detach(): its node, and a session with each component that is up.
class Presence {
 public:
  struct Start {
    NodeOptions node;
    LinkListener& listener;
    PeerPolicy& policy;
    std::string summary;
    std::shared_ptr<const Member> member;  ///< the member that all others are; null: they are unknown
    std::string user;                      ///< in kernel.user
    std::string own_host;                  ///< PeerIdentity::host of this machine
    bool is_stand_in = false;
    /// Another live component uses the id of this one, and used it before.
    std::function<void()> displaced;
  };
  /// Begin of the Identity::full_name of a stand-in, so that a component does not give way to its own stand-in.
  static constexpr std::string_view kStandInName = "stand-in";

  Presence(Start start, Scheduler& scheduler, Log log);
  ~Presence();

  /// As Node::open(); may be called again after an error.
  Result<void> open(transport::Transports& transports);
  /// No call to the listener from now on.
  void end();
  /// A call to the listener is in progress: destroy this object in a later turn.
  bool is_busy() const { return context_.calls > 0; }

  Session* find(OwnerId peer);
  std::vector<OwnerId> peers() const;
  /// Sends the subscription to the owners that it concerns.
  void subscribe(const SubscriptionSpec& spec);
  void unsubscribe(std::uint32_t id);
  void describe(const std::string& summary);
  /// What the space publishes to kLinkItself: all own tuples, and the end of their snapshot.
  void observe(std::span<const Change> changes);
  const SessionCounters& counters() const { return context_.counters; }
  const Node* node() const { return node_.get(); }

 private:
  static constexpr Duration kYoung = std::chrono::seconds(10);

  NodeCallbacks node_calls();
  void on_host(HostEvent event, const Identity& host);
  void on_id_taken(const Identity& other);
  void meet(const Identity& host);
  void part(OwnerId peer, PeerEvent how);
  void again(OwnerId peer, void (Session::*begin)());
  void introduce(OwnerId id, Session& session);
  bool is_here(const Identity& host) const;
  void find_place(OwnerId kernel);
  PeerIdentity identity_of(const Identity& host) const;
  std::unique_ptr<Session> make_session(const Identity& host);

  // What kernels see of this component (presence.cpp).
  void begin_observing();
  void show_name();
  void set_first_tuples();
  void refresh();
  void all_keys_known();
  void show_keys();
  void set_tuple(std::string_view key, std::string value);
  std::string subscribers_text() const;

  Start start_;
  base::LimitedLog log_;
  SessionContext context_;
  SteadyTime opened_{};
  std::string name_;  ///< of the component, empty: it gave none
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;
  struct Peer {
    PeerIdentity identity;
    std::unique_ptr<Session> session;
  };
  std::map<OwnerId, Peer> peers_;
  std::map<OwnerId, KernelSession*> kernels_;  ///< among the sessions
  KernelSession::View view_;
  bool keys_changed_ = false;
  bool keys_known_ = false;  ///< all of them: the first snapshot of own tuples has ended
  unsigned refreshes_ = 0;
  std::vector<LinkState> links_before_;
  Timer refresh_;
  std::unique_ptr<Node> node_;
};

}  // namespace rubicon::tuples::peis
