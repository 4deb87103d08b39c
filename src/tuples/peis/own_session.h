#pragma once

#include <map>
#include <optional>
#include <string>

#include "tuples/peis/session.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// With a component of ours. The messages are kernel messages with an annex; replies, summaries and the ends of
/// snapshots have ports of their own.
class OwnSession final : public Session {
 public:
  using Session::Session;

  void publish(const Change& change) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  void describe(const std::string& summary) override;
  void receive(Port port, ByteView body) override;
  void forgotten() override;
  std::vector<std::string> patterns() const override;
  void back() override;

 private:
  void publish(const TupleSet& set);
  void publish(const TupleGone& gone);
  void publish(const SnapshotEnd& end);
  void publish(const Restart& restart);
  void restamp(Bytes& body, Duration remaining) override;
  bool send_next() override;
  void send_subscribe(const SubscriptionSpec& spec);
  void send_unsubscribe(std::uint32_t id);

  void on_push(ByteView body);
  void on_subscribe(ByteView body);
  void on_unsubscribe(ByteView body);
  void on_set(ByteView body);
  void on_reply(ByteView body);
  void on_control(ByteView body);

  Bytes body_;                                     ///< of the last tuple that was published
  std::map<std::uint32_t, std::string> patterns_;  ///< of the peer, by id

  std::uint64_t last_request_ = 0;  ///< highest number of its remote sets

  // Due, in this order.
  bool forget_ = false;
  std::map<std::uint32_t, std::optional<SubscriptionSpec>>
      subscription_changes_;  ///< own subscriptions by id; none: it ends
  std::optional<std::string> summary_;
};

}  // namespace rubicon::tuples::peis
