#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "tuples/link.h"

namespace rubicon::tuples::carry {

/// Receives what the own component of the carrier sees of an engine; engines have numbers from 0.
class TapEvents {
 public:
  virtual ~TapEvents() = default;
  /// False: the component itself does not hear of it.
  virtual bool on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) = 0;
  virtual void on_summary(std::size_t engine, OwnerId peer, std::string_view summary) = 0;
  /// The component left: its view of the engine is empty.
  virtual void on_detached(std::size_t engine) = 0;
  /// The summary to show in place of the own one.
  virtual std::string shown(std::string summary) const = 0;
};

/// An engine as the components of a process use it; shows what one of them sees. The engine and the events outlive it
/// and its links.
class TappedEcology final : public Ecology {
 public:
  TappedEcology(Ecology& engine, std::size_t number, OwnerId watched, TapEvents& events)
      : engine_(engine), number_(number), watched_(watched), events_(events) {}

  Result<std::unique_ptr<Link>> join(OwnerId id) override;

 private:
  Ecology& engine_;
  std::size_t number_;
  OwnerId watched_;
  TapEvents& events_;
};

class StandInPort;

/// Receives what the links of stand-ins bring.
class StandInEvents {
 public:
  virtual ~StandInEvents() = default;
  virtual void on_changes(const StandInPort& reader, OwnerId owner, std::span<const Change> changes) = 0;
  virtual void on_subscribe(StandInPort& owner, OwnerId subscriber, const SubscriptionSpec& spec) = 0;
  virtual void on_unsubscribe(const StandInPort& owner, OwnerId subscriber, std::uint32_t subscription) = 0;
  virtual void on_remote_set(StandInPort& owner, const RemoteSet& set) = 0;
  virtual bool on_reply(const StandInPort& reader, OwnerId from, const Reply& reply) = 0;
  virtual void on_met(const StandInPort& by, OwnerId peer, PeerEvent event) = 0;
};

/// A stand-in: its link to an engine where its component is not.
class StandInPort final : public LinkListener {
 public:
  /// The events outlive it.
  StandInPort(const PeerIdentity& component, std::size_t origin, std::size_t engine, std::unique_ptr<Link> link,
              StandInEvents& events)
      : component(component), origin(origin), engine(engine), link_(std::move(link)), events_(events) {}
  ~StandInPort() override { link_->detach(); }

  Link& link() { return *link_; }
  void begin(std::uint64_t incarnation) {
    incarnation_ = incarnation;
    link_->attach(*this, incarnation);
  }
  /// No event follows.
  void end() {
    ended_ = true;
    link_->detach();
  }
  std::uint64_t incarnation() const { return incarnation_; }
  std::uint32_t new_subscription() { return ++last_subscription_; }
  /// Whether it can send to the component.
  bool sees(OwnerId peer) const { return peers_.contains(peer); }
  /// The number that a remote set to this owner has to be above. The owner knows it also if it was away meanwhile.
  std::uint64_t last_request(OwnerId owner) const {
    const auto found = last_requests_.find(owner);
    return found == last_requests_.end() ? last_forgotten_ : found->second;
  }
  /// A remote set with this number was sent to the owner.
  void requested(OwnerId owner, std::uint64_t number) {
    if (last_requests_.size() >= kMaxOwners && !last_requests_.contains(owner)) forget_absent_owners();
    last_requests_[owner] = number;
  }

  /// So many owners of its remote sets are remembered, and those that are there.
  static constexpr std::size_t kMaxOwners = 1000;

  const PeerIdentity component;                 ///< that it stands for
  const std::size_t origin;                     ///< engine where that is met
  const std::size_t engine;                     ///< where the stand-in is
  std::set<std::string, std::less<>> observed;  ///< keys that the link itself knows
  bool is_observed = false;                     ///< by the link itself (kLinkItself)
  SteadyTime used_until{};  ///< without a use after this it ends, if nothing of its component is carried

 private:
  void on_changes(OwnerId owner, std::span<const Change> changes) override {
    if (!ended_) events_.on_changes(*this, owner, changes);
  }
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override {
    if (!ended_) events_.on_subscribe(*this, subscriber, spec);
  }
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override {
    if (!ended_) events_.on_unsubscribe(*this, subscriber, id);
  }
  void on_remote_set(const RemoteSet& set) override {
    if (!ended_) events_.on_remote_set(*this, set);
  }
  bool on_reply(OwnerId from, const Reply& reply) override { return ended_ || events_.on_reply(*this, from, reply); }
  void on_peer(const PeerIdentity& peer, PeerEvent event) override {
    if (ended_) return;
    if (event == PeerEvent::kUp) {
      peers_.insert(peer.id);
    } else {
      peers_.erase(peer.id);
    }
    events_.on_met(*this, peer.id, event);
  }
  void on_summary(OwnerId, std::string_view) override {}
  void forget_absent_owners() {
    std::erase_if(last_requests_, [this](const auto& one) {
      if (sees(one.first)) return false;
      last_forgotten_ = std::max(last_forgotten_, one.second);
      return true;
    });
  }

  std::unique_ptr<Link> link_;
  StandInEvents& events_;
  std::uint64_t incarnation_ = 0;
  std::uint32_t last_subscription_ = 0;
  std::set<OwnerId> peers_;
  std::map<OwnerId, std::uint64_t> last_requests_;  ///< highest number of its remote sets, by owner
  std::uint64_t last_forgotten_ = 0;                ///< the highest of owners that are not remembered any more
  bool ended_ = false;
};

}  // namespace rubicon::tuples::carry
