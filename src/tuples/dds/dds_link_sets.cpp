#include <utility>

#include "tuples/dds/dds_link.h"

namespace rubicon::tuples::dds {

namespace {

/// Pause before a component is asked for its times again.
constexpr Duration kAskAgain = std::chrono::seconds(1);

}  // namespace

void DdsLink::on_set(RemoteSet&& set) {
  auto* peer = find_up(reading_from_);
  if (!listener_ || !peer) return;
  EarlySets::One one{std::move(set), peer->participant, peer->incarnation, reading_sent_, scheduler_.now()};
  if (is_early(*peer, one)) return hold_early(*peer, std::move(one));
  take_set(*peer, std::move(one));
}

void DdsLink::take_set(Peer& peer, EarlySets::One&& one) {
  auto& set = one.set;
  if (set.request <= peer.last_request) return;
  peer.last_request = set.request;
  if (set.time_to_live > Duration(0)) set.time_to_live = left_of(peer, one);
  listener_->on_remote_set(set);
}

/// Of its time to live. Zero means that none was given: one that is over has a negative rest.
Duration DdsLink::left_of(const Peer& peer, const EarlySets::One& one) const {
  const auto age = one.sent ? peer.ages.age(*one.sent, shared_.since_boot()) : std::nullopt;
  const auto left = age ? one.set.time_to_live - *age : Duration(0);
  return left > Duration(0) ? left : Duration(-1);
}

/// Those of a component stay in order.
bool DdsLink::is_early(const Peer& peer, const EarlySets::One& one) {
  return early_sets_.has(one.set.from) || waits_for_times(peer, one);
}

/// Not for longer than it could live.
bool DdsLink::waits_for_times(const Peer& peer, const EarlySets::One& one) const {
  const auto& lives = one.set.time_to_live;
  if (lives <= Duration(0) || !one.sent || peer.ages.age(*one.sent, shared_.since_boot())) return false;
  return scheduler_.now() - one.since < lives;
}

void DdsLink::hold_early(Peer& peer, EarlySets::One&& one) {
  const auto from = one.set.from;
  const auto request = one.set.request;
  if (waits_for_times(peer, one) && !early_sets_.has(from)) send_times(from, peer, true);
  if (!early_sets_.add(std::move(one)))
    return reply({from, request, Verdict::kRefused, ErrorCode::kBusy,
                  "too many requests wait until this process knows whether they may be carried out"});
  take_early_after(kAskAgain);
}

void DdsLink::take_early_after(Duration pause) {
  if (early_sets_timer_.pending()) return;
  early_sets_timer_ = scheduler_.after(pause, [this] { take_early(); });
}

/// Of a sender that is gone nothing is taken.
void DdsLink::take_early() {
  early_sets_timer_.cancel();
  for (auto& one : early_sets_.take()) {
    reading_from_ = one.set.from;
    auto* peer = listener_ ? find_up(reading_from_) : nullptr;
    if (!peer || peer->participant != one.sender || peer->incarnation != one.incarnation) continue;
    if (!early_sets_.has(reading_from_) && !waits_for_times(*peer, one)) {
      take_set(*peer, std::move(one));
      continue;
    }
    if (!early_sets_.has(reading_from_)) send_times(reading_from_, *peer, true);
    early_sets_.add(std::move(one));
  }
  if (!early_sets_.empty()) take_early_after(kAskAgain);
}

void DdsLink::on_times(const distant::FrameTimes& times) {
  auto* peer = find_up(reading_from_);
  if (!peer) return;
  reading_sent_ = times.sent;
  peer->ages.arrived(times, shared_.since_boot());
  if (times.asks) send_times(reading_from_, *peer, false);
  if (times.echo && early_sets_.has(reading_from_)) {
    const auto from = reading_from_;
    take_early();
    reading_from_ = from;
  }
}

void DdsLink::send_times(OwnerId id, Peer& peer, bool asks) {
  auto* channel = channel_to(id, peer);
  if (!channel) return;
  channel->add_times(asks);
  flush_soon_.request();
}

}  // namespace rubicon::tuples::dds
