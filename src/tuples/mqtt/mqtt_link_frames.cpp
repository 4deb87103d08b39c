#include <fmt/format.h>

#include "tuples/mqtt/mqtt_link.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Bytes of requests whose age is not known yet: of one component, and of all to a link. The longest time that they
/// wait.
constexpr std::size_t kMaxHeld = std::size_t{32} << 20, kMaxAllHeld = std::size_t{64} << 20;
constexpr Duration kMaxHold = std::chrono::seconds(30);
constexpr Duration kAskAgain = std::chrono::seconds(1);

}  // namespace

// -- what is received

void MqttLink::arrived(const FrameHead& head, ByteView entries) {
  if (auto* peer = find_up(head.source); peer && peer->identity.incarnation == head.source_incarnation)
    channel(*peer).arrived(head, entries);
}

/// Each entry may end the link.
class MqttLink::Reader final : public distant::FrameReader {
 public:
  explicit Reader(MqttLink& link) : link_(link), alive_(link.lifetime_.watch()) {}
  bool ended() const { return alive_.ended(); }

  void on_changes(std::span<const Change> changes) override {
    if (!ended()) link_.on_changes(changes);
  }
  void on_set(RemoteSet&& set) override {
    if (!ended()) link_.on_set(std::move(set));
  }
  void on_reply(Reply&& reply) override {
    if (!ended()) link_.on_reply(std::move(reply));
  }
  void on_times(const distant::FrameTimes& times) override {
    if (!ended()) link_.on_times(times);
  }
  void on_subscription(SubscriptionSpec&& spec) override {
    if (!ended()) link_.on_subscription(std::move(spec));
  }
  void on_unsubscription(std::uint32_t id) override {
    if (!ended()) link_.on_unsubscription(id);
  }

 private:
  MqttLink& link_;
  base::Lifetime::Watch alive_;
};

void MqttLink::received(OwnerId id, ByteView entries) {
  if (!find_up(id)) return;
  reading_from_ = id;
  reading_sent_.reset();
  Reader reader(*this);
  Bytes unpacked;
  auto plain = ecology_.packing_.unpacked(entries, unpacked);
  auto read = plain ? distant::read_frame(*plain, id, who_.id, reader) : Result<void>(fail(std::move(plain.error())));
  if (!read && !reader.ended()) ecology_.log_.warning(fmt::format("frame {}", number(id)), read.error().text);
}

void MqttLink::on_changes(std::span<const Change> changes) {
  if (find_up(reading_from_) && listener_) listener_->on_changes(reading_from_, changes);
}

void MqttLink::on_reply(Reply&& reply) {
  if (listener_ && !listener_->on_reply(reading_from_, reply))
    ecology_.log_.warning(fmt::format("replies of {}", number(reading_from_)), unasked_reply(reading_from_));
}

void MqttLink::on_subscription(SubscriptionSpec&& spec) {
  if (find_up(reading_from_) && listener_) listener_->on_subscribe(reading_from_, spec);
}

void MqttLink::on_unsubscription(std::uint32_t id) {
  if (find_up(reading_from_) && listener_) listener_->on_unsubscribe(reading_from_, id);
}

// -- requests, which may be late

void MqttLink::on_times(const distant::FrameTimes& times) {
  auto* peer = find_up(reading_from_);
  if (!peer) return;
  reading_sent_ = times.sent;
  peer->channel->ages().arrived(times, ecology_.since_boot_());
  if (times.asks) {
    peer->channel->add_times(false);
    ecology_.flush_soon_.request();
  }
  if (times.echo && !peer->held.empty()) take_held(reading_from_);
}

void MqttLink::on_set(RemoteSet&& set) {
  auto* peer = find_up(reading_from_);
  if (!listener_ || !peer) return;
  const auto lives = set.time_to_live;
  const bool waits = !peer->held.empty() || (lives > Duration(0) && reading_sent_ &&
                                             !peer->channel->ages().age(*reading_sent_, ecology_.since_boot_(), lives));
  if (!waits) return take_set(*peer, std::move(set), reading_sent_);
  const auto size = size_of(set);
  if (auto may = policy_->may_set(set); !may) return refuse(set, may.error());
  if (peer->held_bytes + size > kMaxHeld || held_bytes_ + size > kMaxAllHeld)
    return reply({set.from, set.request, Verdict::kRefused, ErrorCode::kBusy,
                  "too many requests wait until this process knows whether they may be carried out"});
  if (peer->held.empty()) peer->channel->add_times(true), ecology_.flush_soon_.request();
  peer->held_bytes += size;
  held_bytes_ += size;
  peer->held.push_back({std::move(set), reading_sent_.value_or(Duration(0)), ecology_.scheduler_.now()});
  look_at_held();
}

/// No waiting request of that component has a lower number.
void MqttLink::refuse(const RemoteSet& set, const Error& why) {
  const Reply answer{set.from, set.request, Verdict::kRefused, why.code, why.text};
  policy_->answered(set, answer);
  reply(answer);
}

void MqttLink::look_at_held() {
  if (held_timer_.pending()) return;
  held_timer_ = ecology_.scheduler_.after(kAskAgain, [this] {
    std::vector<OwnerId> ids;
    for (const auto& [id, one] : peers_) {
      if (!one.held.empty()) ids.push_back(id);
    }
    const auto alive = lifetime_.watch();
    for (const auto id : ids) {
      take_held(id);
      if (alive.ended()) return;
    }
  });
}

/// Exactly zero remains: a negative time, because zero means that none was given.
void MqttLink::take_set(Peer& peer, RemoteSet&& set, std::optional<Duration> sent) {
  if (set.request <= peer.last_request) return;  // sent again because its acknowledgement reached no component
  peer.last_request = set.request;
  if (set.time_to_live > Duration(0)) {
    const auto age = sent ? peer.channel->ages().age(*sent, ecology_.since_boot_(), set.time_to_live) : std::nullopt;
    const auto left = age ? set.time_to_live - *age : Duration(0);
    set.time_to_live = left > Duration(0) ? left : Duration(-1);
  }
  listener_->on_remote_set(set);
}

/// Sets whose age is known, or whose time is over by the own clock, in order.
void MqttLink::take_held(OwnerId id) {
  const auto before = std::exchange(reading_from_, id);
  const auto alive = lifetime_.watch();
  for (auto* peer = find_up(id); peer && listener_ && !peer->held.empty(); peer = find_up(id)) {
    auto& first = peer->held.front();
    const auto lives = first.set.time_to_live;
    const bool known = peer->channel->ages().age(first.sent, ecology_.since_boot_(), lives).has_value();
    if (!known && lives > Duration(0) && ecology_.scheduler_.now() - first.since < std::min(lives, kMaxHold)) break;
    auto one = std::move(first);
    peer->held_bytes -= size_of(one.set);
    held_bytes_ -= size_of(one.set);
    peer->held.pop_front();
    take_set(*peer, std::move(one.set), one.sent);
    if (alive.ended()) return;
  }
  reading_from_ = before;
  auto* peer = find_up(id);
  if (!peer || peer->held.empty()) return;
  peer->channel->add_times(true);
  ecology_.flush_soon_.request();
  look_at_held();
}

}  // namespace rubicon::tuples::mqtt
