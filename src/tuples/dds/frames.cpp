#include "tuples/dds/frames.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "tuples/refusals.h"
#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

/// Pause before a component is asked for its times again.
constexpr Duration kAskAgain = std::chrono::seconds(1);

}  // namespace

std::size_t Frames::collect() {
  return dds::take<rubicon_wire_Frame>(entities_.frame_reader(), kSamples, [&](const auto& sample, const auto& info) {
    if (!info.valid_data || sample.target_incarnation != own_.incarnation) return;
    const auto* writer = presences_.writer(entities_.frame_reader(), info.publication_handle);
    // Without a writer: it went before its first frame was read, so its component is not known.
    if (!writer || !writer->source || presences_.is_banned(writer->participant)) return;
    const OwnerId source{sample.source};
    if (*writer->source != source) {
      log_.warning(
          fmt::format("forged {}", sample.source),
          fmt::format("frames in the name of component {} come from another component: dropped", sample.source));
      return;
    }
    const auto& bytes = sample.content;
    news_.push_back({{source, sample.source_incarnation, writer->participant},
                     Bytes(bytes._buffer, bytes._buffer + bytes._length)});
  });
}

bool Frames::take() {
  const auto count = collect();
  const auto news = std::exchange(news_, {});
  for (const auto& one : news) {
    if (own_.listener) place(one.sender, one.content);
  }
  return count >= kSamples;
}

/// Which start of which component it is from: the one that is up, or one that may be up soon.
void Frames::place(const Sender& sender, ByteView content) {
  if (sender.id == own_.id) return conflicts_.on_frame(sender.incarnation, content);
  const auto* peer = presences_.find_up(sender.id);
  if (peer && sender.incarnation == peer->incarnation && sender.participant == peer->participant)
    return deliver(sender.id, content);
  // It may be the component, whose former participant is not lost here yet, or a start after its clock was set back.
  hold(sender, content);
}

void Frames::hold(const Sender& sender, ByteView content) {
  if (!early_frames_.add(sender, content, shared_.scheduler.now())) {
    log_.warning("held", "frames of a start that is not up, or not yet, fill the buffer: dropped");
    return;
  }
  if (!early_timer_.pending())
    early_timer_ = shared_.scheduler.after(shared_.options.lease, [this] { drop_expired(); });
}

void Frames::drop_expired() {
  const auto lease = shared_.options.lease;
  early_frames_.drop_until(shared_.scheduler.now() - lease);
  if (!early_frames_.empty()) early_timer_ = shared_.scheduler.after(lease, [this] { drop_expired(); });
}

void Frames::met(const Sender& sender) {
  auto& from = senders_[sender.id];
  if (std::exchange(from.requests_of, sender.incarnation) != sender.incarnation) from.last_request = 0;
  for (const auto& content : early_frames_.take(sender)) {
    if (own_.listener) deliver(sender.id, content);
  }
}

void Frames::drop_held() {
  early_frames_.clear();
  early_timer_.cancel();
  early_sets_.clear();
  early_sets_timer_.cancel();
}

void Frames::clear() {
  drop_held();
  news_.clear();
  senders_.clear();
}

void Frames::deliver(OwnerId id, ByteView content) {
  reading_from_ = id;
  reading_sent_.reset();
  if (auto read = distant::read_frame(content, id, own_.id, *this); !read)
    log_.warning(fmt::format("frame {}", number(id)), read.error().text);
}

void Frames::on_changes(std::span<const Change> changes) {
  if (own_.listener) own_.listener->on_changes(reading_from_, changes);
}

void Frames::on_reply(Reply&& reply) {
  if (own_.listener && !own_.listener->on_reply(reading_from_, reply))
    log_.warning(fmt::format("replies of {}", number(reading_from_)), unasked_reply(reading_from_));
}

void Frames::on_set(RemoteSet&& set) {
  const auto* peer = presences_.find_up(reading_from_);
  if (!own_.listener || !peer) return;
  EarlySets::One one{std::move(set), peer->participant, peer->incarnation, reading_sent_, shared_.scheduler.now()};
  if (is_early(one)) return hold_early(std::move(one));
  take_set(std::move(one));
}

void Frames::take_set(EarlySets::One&& one) {
  auto& set = one.set;
  auto& last_request = senders_[set.from].last_request;
  if (set.request <= last_request) return;
  last_request = set.request;
  if (set.time_to_live > Duration(0)) set.time_to_live = left_of(one);
  own_.listener->on_remote_set(set);
}

/// What is left of its time to live. If nothing is left, the result is negative: zero means that none was given.
Duration Frames::left_of(const EarlySets::One& one) const {
  const auto age = age_of(one);
  const auto left = age ? one.set.time_to_live - *age : Duration(0);
  return left > Duration(0) ? left : Duration(-1);
}

/// How long ago it was sent. nullopt: its sender does not say it, or has to be asked (again).
std::optional<Duration> Frames::age_of(const EarlySets::One& one) const {
  const auto from = senders_.find(one.set.from);
  if (!one.sent || from == senders_.end()) return std::nullopt;
  return from->second.ages.age(*one.sent, shared_.since_boot(), one.set.time_to_live);
}

/// Whether it has to wait: the sets of one component stay in order.
bool Frames::is_early(const EarlySets::One& one) const {
  return early_sets_.has(one.set.from) || waits_for_times(one);
}

/// Whether its age is needed and not known. It waits no longer than it may live.
bool Frames::waits_for_times(const EarlySets::One& one) const {
  const auto& lives = one.set.time_to_live;
  if (lives <= Duration(0) || !one.sent || age_of(one)) return false;
  return shared_.scheduler.now() - one.since < lives;
}

void Frames::hold_early(EarlySets::One&& one) {
  const auto from = one.set.from;
  const auto request = one.set.request;
  if (waits_for_times(one) && !early_sets_.has(from)) answers_.times(from, true);
  if (!early_sets_.add(std::move(one)))
    return answers_.reply({from, request, Verdict::kRefused, ErrorCode::kBusy,
                           "too many requests wait until this process knows whether they may be carried out"});
  take_early_after(kAskAgain);
}

void Frames::take_early_after(Duration pause) {
  if (early_sets_timer_.pending()) return;
  early_sets_timer_ = shared_.scheduler.after(pause, [this] { take_early(); });
}

/// Passes on the waiting sets whose age is known now. Those of a sender that is gone are dropped.
void Frames::take_early() {
  early_sets_timer_.cancel();
  for (auto& one : early_sets_.take()) {
    const auto from = one.set.from;
    const auto* peer = own_.listener ? presences_.find_up(from) : nullptr;
    if (!peer || peer->participant != one.sender || peer->incarnation != one.incarnation) continue;
    if (!early_sets_.has(from) && !waits_for_times(one)) {
      take_set(std::move(one));
      continue;
    }
    if (!early_sets_.has(from)) answers_.times(from, true);
    early_sets_.add(std::move(one));
  }
  if (!early_sets_.empty()) take_early_after(kAskAgain);
}

void Frames::on_times(const distant::FrameTimes& times) {
  if (!presences_.find_up(reading_from_)) return;
  reading_sent_ = times.sent;
  senders_[reading_from_].ages.arrived(times, shared_.since_boot());
  if (times.asks) answers_.times(reading_from_, false);
  if (times.echo && early_sets_.has(reading_from_)) take_early();
}

distant::FrameTimes Frames::times_for(OwnerId id, bool asks) const {
  const auto from = senders_.find(id);
  const auto ages = from == senders_.end() ? distant::FrameAges() : from->second.ages;
  return ages.next(shared_.since_boot(), asks);
}

}  // namespace rubicon::tuples::dds
