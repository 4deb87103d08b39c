#pragma once

#include <map>
#include <memory>
#include <string>

#include "tuples/host_policy.h"
#include "tuples/peis/peis_options.h"
#include "tuples/peis/session.h"

namespace rubicon::tuples::peis {

/// One start of a component, from attach() to detach(): its node, and a session with each component that is up.
class Presence {
 public:
  struct Start {
    NodeOptions node;
    LinkListener& listener;
    HostPolicy& policy;
    std::string summary;
    /// Another live component uses the id of this one, and used it before.
    std::function<void()> displaced;
  };
  Presence(Start start, Scheduler& scheduler, Log log);
  ~Presence();

  /// As Node::open(); may be called again after an error.
  Result<void> open(transport::Transports& transports);
  /// No call to the listener from now on.
  void end();
  /// A call to the listener is under way: destroy this in a later turn.
  bool is_busy() const { return calls_ > 0; }

  Session* find(OwnerId peer);
  std::vector<OwnerId> peers() const;
  /// Sends it to the owners that it is for.
  void subscribe(const SubscriptionSpec& spec);
  void unsubscribe(std::uint32_t id);
  void describe(const std::string& summary);
  const SessionCounters& counters() const { return context_.counters; }
  const Node* node() const { return node_.get(); }

 private:
  static constexpr Duration kYoung = std::chrono::seconds(10);

  NodeCalls node_calls();
  void on_host(HostEvent event, const Identity& host);
  void on_id_taken();
  void meet(const Identity& host);
  void part(OwnerId peer, PeerEvent how);
  void introduce(OwnerId id, Session& session);
  PeerIdentity identity_of(const Identity& host) const;
  std::unique_ptr<Session> make_session(const Identity& host);

  Start start_;
  base::LimitedLog log_;
  SessionContext context_;
  SteadyTime opened_{};
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;
  struct Peer {
    PeerIdentity identity;
    std::unique_ptr<Session> session;
  };
  std::map<OwnerId, Peer> peers_;
  int calls_ = 0;
  std::unique_ptr<Node> node_;
};

}  // namespace rubicon::tuples::peis
