#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "tuples/distant/frame_codec.h"
#include "tuples/host/host_ecology.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::host {

/// The link of one component: tells the other processes, and this one, that it is there and what it subscribes to, and
/// sends to each component by the process that has it.
class HostLink final : public Link {
 public:
  HostLink(HostEcology& ecology, StandIn who, std::unique_ptr<IdLock> lock);
  ~HostLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return *policy_; }

  // For the ecology. Each may detach the link, or destroy it.
  OwnerId id() const { return who_.id; }
  bool attached() const { return listener_ != nullptr; }
  std::uint64_t incarnation() const { return incarnation_; }
  bool is_stand_in() const { return carrier_of(who_.host) != model::kNoOwner; }
  /// Says that the component is there.
  void show(Connection& to) const { to.send(shown()); }
  /// Sends what it subscribes to.
  void ask(Connection& to) const;
  const std::map<std::uint32_t, SubscriptionSpec>& subscriptions() const { return subscriptions_; }
  void peer_up(const HostEcology::Present& peer);
  void peer_down(const PeerIdentity& who, PeerEvent how);
  /// Null: that component was not reported to it.
  LinkListener* listener(OwnerId peer) const { return known_.contains(peer) ? listener_ : nullptr; }
  /// kInvalid: the entries are none.
  Result<void> deliver(OwnerId source, ByteView entries);
  /// Another process has a better right to the id.
  void displace();

 private:
  struct Delivery;

  void introduce();
  Record shown() const { return {Record::Type::kUp, who_.id, {}, incarnation_, who_.host, base::as_bytes(summary_)}; }
  /// How a component is reached.
  struct Way {
    Connection* connection = nullptr;  ///< null: it is not present
    OwnerId peer{};
    std::uint64_t incarnation = 0;
  };
  Way way_to(OwnerId peer) const;
  void send(const Way& way);

  HostEcology& ecology_;
  StandIn who_;
  std::unique_ptr<IdLock> lock_;  ///< null: a stand-in
  std::unique_ptr<PeerPolicy> policy_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  bool introduced_ = false;  ///< the listener knows who was there when it was attached
  bool displaced_ = false;
  std::string summary_;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;
  std::set<OwnerId> known_;       ///< those that were reported to the listener
  distant::FrameWriter entries_;  ///< for send(), empty between calls
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::host
