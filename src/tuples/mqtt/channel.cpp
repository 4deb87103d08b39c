#include "tuples/mqtt/channel.h"

#include <algorithm>

namespace rubicon::tuples::mqtt {

namespace {

/// An acknowledgement travels in a frame. It goes alone after this number of frames, or after this time.
constexpr unsigned kAnswerFrames = 16;
constexpr Duration kAnswerTime = std::chrono::milliseconds(50);
/// If no acknowledgement comes for this time, or this number of round trips, the kept frames are sent again; then after
/// twice the time, up to the maximum.
constexpr Duration kRepeat = std::chrono::seconds(1), kMaxRepeat = std::chrono::seconds(8);
constexpr int kRepeatTrips = 4;
/// A large frame that was sent so often, for so long, while smaller ones arrived, exceeds what the broker takes: one of
/// version 3.1.1 does not say so.
constexpr unsigned kLargeSent = 3;
constexpr Duration kLargeTime = std::chrono::seconds(6);
/// The other side can request missing frames at most this often.
constexpr Duration kAgainPause = std::chrono::milliseconds(100);
/// Over which the pace of acknowledgements is measured.
constexpr Duration kPaceTime = std::chrono::seconds(1);

}  // namespace

Channel::Channel(Scheduler& scheduler, const Ends& ends, std::uint64_t stream, Callbacks calls)
    : scheduler_(scheduler),
      ends_(ends),
      callbacks_(std::move(calls)),
      stream_(stream),
      repeat_pause_(kRepeat),
      answer_later_(scheduler, [this] { answer(); }),
      repeat_(scheduler, [this] { send_again(); }) {}

void Channel::push(Entry entry, std::size_t size) {
  entries_.emplace_back(std::move(entry), size);
  waiting_ += size;
}

void Channel::add(Bytes entries) {
  const auto size = entries.size();
  push(std::move(entries), size);
}

void Channel::add(RemoteSet set) {
  const auto size = size_of(set);
  push(TimedSet{std::move(set), scheduler_.now()}, size);
}

void Channel::add_times(bool asks) {
  times_due_ = true;
  asks_ |= asks;
}

/// Of a frame; those of sets whose time to live ended while they waited are left out.
Bytes Channel::next_entries() {
  distant::FrameWriter frame;
  frame.add(ages_.next(callbacks_.since_boot(), asks_));
  const auto begin = frame.size();
  times_due_ = asks_ = false;
  while (!entries_.empty()) {
    const auto& [entry, size] = entries_.front();
    if (frame.size() > begin && frame.size() + size > kFrameBytes) break;
    if (const auto* bytes = std::get_if<Bytes>(&entry)) {
      frame.add(ByteView(*bytes));
    } else {
      const auto& [set, since] = std::get<TimedSet>(entry);
      auto left = set;
      left.time_to_live -= scheduler_.now() - since;
      if (set.time_to_live == Duration(0) || left.time_to_live > Duration(0)) frame.add(left);
    }
    waiting_ -= size;
    entries_.pop_front();
  }
  return frame.take();
}

bool Channel::may_send() const {
  return kept_.size() < credit_ && (kept_.empty() || kept_bytes_ < most_under_way_);
}

void Channel::flush() {
  if (unsent_ < next_ && !send_kept(unsent_)) return;
  while ((!entries_.empty() || times_due_) && may_send()) {
    if (kept_.empty()) oldest_since_ = scheduler_.now();
    auto& frame = kept_.emplace_back(Kept{next_++, next_entries(), scheduler_.now()});
    kept_bytes_ += frame.entries.size();
    if (!send(frame)) return;
  }
}

FrameHead Channel::head() const {
  FrameHead head;
  head.source = ends_.self;
  head.source_incarnation = ends_.self_incarnation;
  head.target = ends_.peer;
  head.target_incarnation = ends_.peer_incarnation;
  head.stream = stream_;
  head.heard_stream = heard_stream_;
  head.heard = heard_;
  head.credit = callbacks_.credit();
  return head;
}

bool Channel::send(Kept& frame) {
  auto with = head();
  with.number = frame.number;
  with.first = kept_.front().number;
  answer_later_.clear();
  unanswered_ = 0;
  if (frame.number < unsent_ && callbacks_.losses) ++callbacks_.losses->again;
  if (!repeat_.is_set()) repeat_.set(repeat_pause_);
  auto sent = callbacks_.send(with, frame.entries);
  if (sent == Sent::kTooLarge) {
    give_up(frame);
    sent = callbacks_.send(with, frame.entries);
  }
  if (sent != Sent::kYes) return false;
  ++frame.sent;
  unsent_ = std::max(unsent_, frame.number + 1);
  return true;
}

/// Gives up the entries of the frame. The frame keeps its number.
void Channel::give_up(Kept& frame) {
  distant::FrameWriter times;
  times.add(ages_.next(callbacks_.since_boot(), false));
  const auto entries = std::exchange(frame.entries, times.take());
  kept_bytes_ -= entries.size() - frame.entries.size();
  callbacks_.too_large(entries);
}

void Channel::too_large(std::uint64_t stream, std::uint64_t number) {
  if (stream != stream_) return;
  const auto frame = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& one) { return one.number == number; });
  if (frame == kept_.end() || frame->entries.size() <= kFrameBytes) return;
  give_up(*frame);
  send_kept(number);
}

bool Channel::is_swallowed(const Kept& frame) const {
  return callbacks_.may_swallow(frame.entries.size()) && frame.missing && frame.sent >= kLargeSent &&
         scheduler_.now() - oldest_since_ > kLargeTime;
}

/// An acknowledgement by itself.
void Channel::answer(bool again) {
  answer_later_.clear();
  unanswered_ = 0;
  auto alone = head();
  alone.again = again;
  callbacks_.send(alone, {});
}

bool Channel::send_kept(std::uint64_t from) {
  return std::all_of(kept_.begin(), kept_.end(), [&](Kept& frame) { return frame.number < from || send(frame); });
}

/// Nothing was acknowledged for a while: the last frames may be lost, and the receiver sees no gap.
void Channel::send_again() {
  if (kept_.empty()) return;
  repeat_pause_ = std::min(2 * repeat_pause_, kMaxRepeat);
  repeat_.set(repeat_pause_);
  if (is_swallowed(kept_.front())) give_up(kept_.front());
  if (kept_.front().entries.size() > kFrameBytes) times_due_ = true;  // a later one shows that this one is missing
  send_kept(0);
  flush();
}

void Channel::reconnected() {
  repeat_pause_ = kRepeat;
  if (!kept_.empty()) oldest_since_ = scheduler_.now();
  if (heard_ > 0 || next_ > 1) answer_later_.advance_to(scheduler_.now() + kAnswerTime);  // says where this side is
  if (send_kept(0)) flush();
}

void Channel::arrived(const FrameHead& head, ByteView entries) {
  acknowledged(head);
  const bool next = head.number != 0 && is_next(head);
  if (next) {
    take(head);
  } else if (head.number != 0 && head.stream == heard_stream_ && head.number <= heard_) {
    answer_later_.advance_to(scheduler_.now() + kAnswerTime);  // its acknowledgement was lost
  } else if (head.number != 0 && !std::exchange(gap_told_, true)) {
    if (callbacks_.losses) ++callbacks_.losses->gaps;
    answer(true);
  }
  flush();
  if (next) callbacks_.received(entries);
}

/// The first frame of a stream that is new here is the first one that its sender still has.
bool Channel::is_next(const FrameHead& head) {
  if (head.stream == heard_stream_) return head.number == heard_ + 1;
  return head.stream > heard_stream_ && head.number == head.first;
}

/// The first frame is answered at once: its sender has little credit before. So are later ones where all have little.
void Channel::take(const FrameHead& head) {
  const auto before = std::exchange(heard_stream_, head.stream);
  const bool begins = before != head.stream;
  if (begins && before != 0) callbacks_.met_again();
  heard_ = head.number;
  gap_told_ = false;
  const auto often = std::clamp(callbacks_.credit() / 2, 1U, kAnswerFrames);
  if (++unanswered_ >= often || begins) return answer();
  answer_later_.advance_to(scheduler_.now() + kAnswerTime);
}

void Channel::acknowledged(const FrameHead& head) {
  if (head.credit > 0) credit_ = std::min(head.credit, kMaxCredit);
  const bool knows_stream = head.heard_stream == stream_;  // else it began anew
  if (knows_stream && head.heard > acknowledged_ && head.heard < next_) {
    acknowledged_ = head.heard;
    forget_up_to(head.heard);
    note_pace();
    repeat_.clear();
    oldest_since_ = scheduler_.now();
    if (!kept_.empty()) repeat_.set(repeat_pause_);
  }
  if (!knows_stream && acknowledged_ > 0 && heard_stream_ == 0) {
    acknowledged_ = 0;  // it began anew before anything of it came
    callbacks_.met_again();
  }
  const auto now = scheduler_.now();
  if (!head.again || kept_.empty() || now - again_at_ < kAgainPause) return;
  again_at_ = now;
  kept_.front().missing = true;
  send_kept(0);
}

/// If a frame was sent again, it is unknown which copy was acknowledged, so the waiting time does not change.
void Channel::forget_up_to(std::uint64_t number) {
  for (; !kept_.empty() && kept_.front().number <= number; kept_.pop_front()) {
    const auto& frame = kept_.front();
    if (frame.sent == 1)
      repeat_pause_ = std::clamp(kRepeatTrips * (scheduler_.now() - frame.since), kRepeat, kMaxRepeat);
    kept_bytes_ -= frame.entries.size();
    taken_bytes_ += frame.entries.size();
  }
}

/// Frames that were sent should arrive within a second, so that a slow connection does not deliver old values: values
/// that wait are merged, sent ones are not.
void Channel::note_pace() {
  const auto took = scheduler_.now() - taken_since_;
  if (took < kPaceTime) return;
  const auto in_a_second = static_cast<std::size_t>(static_cast<double>(taken_bytes_) * (kPaceTime / (1.0 * took)));
  most_under_way_ = std::clamp(in_a_second, kMinUnderWay, kMaxUnderWay);
  taken_bytes_ = 0;
  taken_since_ = scheduler_.now();
}

std::optional<SteadyTime> Channel::unanswered_since() const {
  if (kept_.empty()) return std::nullopt;
  return oldest_since_;
}

}  // namespace rubicon::tuples::mqtt
