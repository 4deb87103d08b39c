#pragma once

#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "tuples/peer_policy.h"

namespace rubicon::tuples {

/// A link that can be cut from some peers and mended: what a torn cable does to one that is real.
class CuttableLink final : public Link, private LinkListener {
 public:
  CuttableLink(std::unique_ptr<Link> link, std::map<OwnerId, CuttableLink*>& all, OwnerId self)
      : link_(std::move(link)), all_(all), self_(self) {
    all_[self] = this;
  }
  ~CuttableLink() override { all_.erase(self_); }
  CuttableLink(const CuttableLink&) = delete;
  CuttableLink& operator=(const CuttableLink&) = delete;

  void cut(OwnerId peer) {
    if (!cuts_.insert(peer).second || !there_.contains(peer) || !listener_) return;
    listener_->on_peer(there_.at(peer), PeerEvent::kLost);
  }
  void mend(OwnerId peer) {
    if (cuts_.erase(peer) == 0 || !there_.contains(peer) || !listener_) return;
    listener_->on_peer(there_.at(peer), PeerEvent::kUp);
    if (!summaries_[peer].empty()) listener_->on_summary(peer, summaries_[peer]);
    for (const auto& [id, spec] : std::map(subscriptions_[peer])) listener_->on_subscribe(peer, spec);
  }

  void attach(LinkListener& listener, std::uint64_t incarnation) override {
    listener_ = &listener;
    link_->attach(*this, incarnation);
  }
  void detach() override {
    listener_ = nullptr;
    link_->detach();
  }
  bool publish(OwnerId subscriber, std::span<const Change> changes) override {
    return cuts_.contains(subscriber) || link_->publish(subscriber, changes);
  }
  void subscribe(const SubscriptionSpec& spec) override { link_->subscribe(spec); }
  void unsubscribe(std::uint32_t id) override { link_->unsubscribe(id); }
  Result<void> remote_set(const RemoteSet& set) override {
    if (cuts_.contains(set.owner)) return fail(ErrorCode::kNotFound, "cut");
    return link_->remote_set(set);
  }
  void reply(const Reply& reply) override {
    if (!cuts_.contains(reply.to)) link_->reply(reply);
  }
  void describe(std::string summary) override { link_->describe(std::move(summary)); }
  PeerPolicy& policy() override { return link_->policy(); }
  bool seeks(std::optional<OwnerId> id) override { return !(id && cuts_.contains(*id)) && link_->seeks(id); }
  std::vector<OwnerId> peers() const override {
    auto there = link_->peers();
    std::erase_if(there, [this](OwnerId peer) { return cuts_.contains(peer); });
    return there;
  }

 private:
  void on_changes(OwnerId owner, std::span<const Change> changes) override {
    if (!cuts_.contains(owner)) listener_->on_changes(owner, changes);
  }
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override {
    subscriptions_[subscriber][spec.id] = spec;
    if (!cuts_.contains(subscriber)) listener_->on_subscribe(subscriber, spec);
  }
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override {
    subscriptions_[subscriber].erase(id);
    if (!cuts_.contains(subscriber)) listener_->on_unsubscribe(subscriber, id);
  }
  void on_remote_set(const RemoteSet& set) override {
    if (!cuts_.contains(set.from)) listener_->on_remote_set(set);
  }
  bool on_reply(OwnerId from, const Reply& reply) override { return listener_->on_reply(from, reply); }
  void on_peer(const PeerIdentity& peer, PeerEvent event) override {
    if (event == PeerEvent::kUp) {
      there_[peer.id] = peer;
    } else {
      there_.erase(peer.id);
      subscriptions_.erase(peer.id);
      summaries_.erase(peer.id);
    }
    if (!cuts_.contains(peer.id)) listener_->on_peer(peer, event);
  }

  void on_summary(OwnerId peer, std::string_view summary) override {
    summaries_[peer] = summary;
    if (!cuts_.contains(peer)) listener_->on_summary(peer, summary);
  }

  std::unique_ptr<Link> link_;
  std::map<OwnerId, CuttableLink*>& all_;
  OwnerId self_;
  LinkListener* listener_ = nullptr;
  std::set<OwnerId> cuts_;
  std::map<OwnerId, PeerIdentity> there_;
  std::map<OwnerId, std::map<std::uint32_t, SubscriptionSpec>> subscriptions_;
  std::map<OwnerId, std::string> summaries_;
};

}  // namespace rubicon::tuples
