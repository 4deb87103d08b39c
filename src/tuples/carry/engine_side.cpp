#include "tuples/carry/engine_side.h"

#include <utility>

#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {

namespace {

/// Passes everything on, both ways.
class TapLink final : public Link, private LinkListener {
 public:
  TapLink(std::unique_ptr<Link> link, std::size_t number, TapEvents& events)
      : link_(std::move(link)), number_(number), events_(events) {
    describe({});
  }
  ~TapLink() override { detach(); }

  void attach(LinkListener& listener, std::uint64_t incarnation) override {
    detach();
    listener_ = &listener;
    link_->attach(*this, incarnation);
  }
  void detach() override {
    if (!std::exchange(listener_, nullptr)) return;
    link_->detach();
    events_.on_detached(number_);
  }
  bool publish(OwnerId subscriber, std::span<const Change> changes) override {
    return link_->publish(subscriber, changes);
  }
  void subscribe(const SubscriptionSpec& spec) override { link_->subscribe(spec); }
  void unsubscribe(std::uint32_t id) override { link_->unsubscribe(id); }
  Result<void> remote_set(const RemoteSet& set) override { return link_->remote_set(set); }
  void reply(const Reply& reply) override { link_->reply(reply); }
  std::vector<OwnerId> peers() const override { return link_->peers(); }
  bool seeks(std::optional<OwnerId> id) override { return link_->seeks(id); }
  void describe(std::string summary) override { link_->describe(events_.shown(std::move(summary))); }
  void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const override {
    link_->each_counter(visit);
  }
  PeerPolicy& policy() override { return link_->policy(); }

 private:
  void on_changes(OwnerId owner, std::span<const Change> changes) override {
    if (listener_) listener_->on_changes(owner, changes);
  }
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override {
    if (listener_) listener_->on_subscribe(subscriber, spec);
  }
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override {
    if (listener_) listener_->on_unsubscribe(subscriber, id);
  }
  void on_remote_set(const RemoteSet& set) override {
    if (listener_) listener_->on_remote_set(set);
  }
  bool on_reply(OwnerId from, const Reply& reply) override { return !listener_ || listener_->on_reply(from, reply); }
  void on_peer(const PeerIdentity& peer, PeerEvent event) override {
    if (events_.on_peer(number_, peer, event) && listener_) listener_->on_peer(peer, event);
  }
  void on_summary(OwnerId peer, std::string_view summary) override {
    events_.on_summary(number_, peer, summary);
    if (listener_) listener_->on_summary(peer, summary);
  }

  std::unique_ptr<Link> link_;
  std::size_t number_;
  TapEvents& events_;
  LinkListener* listener_ = nullptr;
};

}  // namespace

Result<std::unique_ptr<Link>> TappedEcology::join(OwnerId id) {
  auto link = engine_.join(id);
  if (!link || id != watched_) return link;
  return std::make_unique<TapLink>(std::move(*link), number_, events_);
}

}  // namespace rubicon::tuples::carry
