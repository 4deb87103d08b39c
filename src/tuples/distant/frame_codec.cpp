#include "tuples/distant/frame_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

namespace rubicon::tuples::distant {

namespace {

constexpr std::int64_t kMaxDuration = std::chrono::nanoseconds(std::chrono::years(100)).count();

}  // namespace

void FieldWriter::long_number(std::uint64_t value) {
  std::array<std::uint8_t, 10> groups;
  std::size_t size = 0;
  for (; value >= 0x80; value >>= 7) groups[size++] = static_cast<std::uint8_t>(value | 0x80);
  groups[size++] = static_cast<std::uint8_t>(value);
  bytes(ByteView(groups).first(size));
}

void FieldWriter::signed_number(std::int64_t value) {
  number((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
}

void FieldWriter::text(std::string_view text) {
  number(text.size());
  bytes(base::as_bytes(text));
}

std::uint64_t FieldReader::long_number() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const auto part = byte();
    value |= static_cast<std::uint64_t>(part & 0x7f) << shift;
    if ((part & 0x80) == 0) return shift == 63 && part > 1 ? fail_read() : value;
  }
  return fail_read();
}

std::int64_t FieldReader::signed_number() {
  const auto value = number();
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

std::string_view FieldReader::text() {
  const auto size = number();
  if (size > bytes_.size() - at_) return fail_read(), std::string_view();
  const auto found = base::as_text(bytes_.subspan(at_, static_cast<std::size_t>(size)));
  at_ += static_cast<std::size_t>(size);
  return found;
}

ByteView FieldReader::rest() {
  const auto found = bytes_.subspan(at_);
  at_ = bytes_.size();
  return found;
}

Duration FieldReader::duration() {
  return Duration(std::clamp<std::int64_t>(signed_number(), 0, kMaxDuration));
}

OwnerId FieldReader::owner() {
  const auto id = number();
  if (id > 0xffffffff) fail_read();
  return OwnerId(static_cast<std::uint32_t>(id));
}

std::uint8_t FieldReader::fail_read() {
  ok_ = false;
  at_ = bytes_.size();
  return 0;
}

namespace {

enum class Entry : std::uint8_t {
  kSet,
  kDeleted,
  kExpired,
  kRemoteSet,
  kReply,
  kQuestion,
  kAnswer,
  kTimes,
  kSubscribe,
  kUnsubscribe
};

/// Changes that are passed together: few enough to stay in the cache of the processor.
constexpr std::size_t kBatch = 16;

// Bits of a remote set.
constexpr std::uint8_t kAppend = 1, kTimeToLiveGiven = 2, kExpectsSequence = 4, kHasAsker = 8;
// Bits of times.
constexpr std::uint8_t kHasEcho = 1, kAsks = 2;
/// No host runs longer.
constexpr std::uint64_t kMaxMicros = std::chrono::microseconds(std::chrono::years(50)).count();
// Bits of a subscription.
constexpr std::uint8_t kOneOwner = 1, kPassive = 2;

std::int64_t micros(WallTime time) {
  return time.time_since_epoch().count();
}

/// In an entry kSet with an empty key the sequence is the id of the subscription whose snapshot ends, or 0 for Restart,
/// with its time as the write time.
Change read_set_entry(FieldReader& in, OwnerId from) {
  TupleView tuple;
  tuple.owner = from;
  tuple.key = in.text();
  tuple.sequence = in.number();
  tuple.value = in.text();
  tuple.media_type = in.text();
  tuple.creator = in.owner();
  tuple.write_time = in.time();
  tuple.user_time = in.time();
  tuple.expire_time = in.time();
  if (!tuple.key.empty()) return TupleSet{tuple};
  if (tuple.sequence != 0) return SnapshotEnd{static_cast<std::uint32_t>(tuple.sequence)};
  return Restart{tuple.write_time};
}

Change read_change(FieldReader& in, Entry entry, OwnerId from) {
  if (entry == Entry::kSet) return read_set_entry(in, from);
  TupleGone gone;
  gone.how = entry == Entry::kExpired ? EventKind::kExpired : EventKind::kDeleted;
  gone.key = in.text();
  gone.sequence = in.number();
  return gone;
}

RemoteSet read_set(FieldReader& in, OwnerId from, OwnerId to) {
  RemoteSet set;
  set.from = from;
  set.owner = to;
  set.request = in.number();
  set.key = in.text();
  set.value = in.text();
  set.media_type = in.text();
  set.user_time = in.time();
  set.lifetime = in.duration();
  set.time_to_live = in.duration();
  const auto bits = in.byte();
  set.append = (bits & kAppend) != 0;
  set.time_to_live_given = (bits & kTimeToLiveGiven) != 0;
  if ((bits & kExpectsSequence) != 0) set.expected_sequence = in.number();
  if ((bits & kHasAsker) != 0) set.asker = in.text();
  if (set.asker.size() > kMaxAsker) in.fail_read();
  return set;
}

Reply read_reply(FieldReader& in, OwnerId to) {
  Reply reply;
  reply.to = to;
  reply.request = in.number();
  const auto verdict = in.byte();
  const auto code = in.byte();
  if (verdict > static_cast<std::uint8_t>(Verdict::kNoSuchOwner) || code > static_cast<int>(ErrorCode::kIo))
    in.fail_read();
  reply.verdict = static_cast<Verdict>(verdict);
  reply.code = static_cast<ErrorCode>(code);
  reply.text = in.text();
  reply.sequence = in.number();
  return reply;
}

Duration read_micros(FieldReader& in) {
  const auto micros = in.number();
  if (micros > kMaxMicros) return Duration(in.fail_read());
  return std::chrono::microseconds(micros);
}

FrameTimes read_times(FieldReader& in) {
  FrameTimes times;
  const auto bits = in.byte();
  times.asks = (bits & kAsks) != 0;
  times.sent = read_micros(in);
  if ((bits & kHasEcho) == 0) return times;
  times.echo = read_micros(in);
  times.held = read_micros(in);
  return times;
}

}  // namespace

void FrameWriter::add(const Change& change) {
  if (const auto* set = std::get_if<TupleSet>(&change)) return set_entry(set->tuple);
  if (const auto* gone = std::get_if<TupleGone>(&change)) {
    fields_.byte(static_cast<std::uint8_t>(gone->how == EventKind::kExpired ? Entry::kExpired : Entry::kDeleted));
    fields_.text(gone->key);
    fields_.number(gone->sequence);
    return;
  }
  TupleView control;
  if (const auto* end = std::get_if<SnapshotEnd>(&change)) control.sequence = end->subscription;
  if (const auto* restart = std::get_if<Restart>(&change)) control.write_time = restart->since;
  set_entry(control);
}

void FrameWriter::set_entry(const TupleView& tuple) {
  fields_.byte(static_cast<std::uint8_t>(Entry::kSet));
  fields_.text(tuple.key);
  fields_.number(tuple.sequence);
  fields_.text(tuple.value);
  fields_.text(tuple.media_type);
  fields_.number(model::number(tuple.creator));
  fields_.signed_number(micros(tuple.write_time));
  fields_.signed_number(micros(tuple.user_time));
  fields_.signed_number(micros(tuple.expire_time));
}

void FrameWriter::add(const RemoteSet& set, Duration time_to_live) {
  fields_.byte(static_cast<std::uint8_t>(Entry::kRemoteSet));
  fields_.number(set.request);
  fields_.text(set.key);
  fields_.text(set.value);
  fields_.text(set.media_type);
  fields_.signed_number(micros(set.user_time));
  fields_.signed_number(set.lifetime.count());
  fields_.signed_number(time_to_live.count());
  std::uint8_t bits = 0;
  if (set.append) bits |= kAppend;
  if (set.time_to_live_given) bits |= kTimeToLiveGiven;
  if (set.expected_sequence) bits |= kExpectsSequence;
  const bool has_asker = !set.asker.empty() && set.asker.size() <= kMaxAsker;
  if (has_asker) bits |= kHasAsker;
  fields_.byte(bits);
  if (set.expected_sequence) fields_.number(*set.expected_sequence);
  if (has_asker) fields_.text(set.asker);
}

void FrameWriter::add(const Reply& reply) {
  fields_.byte(static_cast<std::uint8_t>(Entry::kReply));
  fields_.number(reply.request);
  fields_.byte(static_cast<std::uint8_t>(reply.verdict));
  fields_.byte(static_cast<std::uint8_t>(reply.code));
  fields_.text(reply.text);
  fields_.number(reply.sequence);
}

void FrameWriter::add(const IdentityCheck& check) {
  fields_.byte(static_cast<std::uint8_t>(check.is_answer ? Entry::kAnswer : Entry::kQuestion));
  fields_.number(check.number);
}

void FrameWriter::add(const FrameTimes& times) {
  const auto micros = [](Duration time) {
    return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(time).count());
  };
  fields_.byte(static_cast<std::uint8_t>(Entry::kTimes));
  fields_.byte(static_cast<std::uint8_t>((times.echo ? kHasEcho : 0) | (times.asks ? kAsks : 0)));
  fields_.number(micros(times.sent));
  if (!times.echo) return;
  fields_.number(micros(*times.echo));
  fields_.number(micros(times.held));
}

Result<void> read_frame(ByteView frame, OwnerId from, OwnerId to, FrameReader& reader) {
  FieldReader in(frame);
  std::array<Change, kBatch> changes;
  std::size_t waiting = 0;
  const auto pass_changes = [&] {
    if (const auto count = std::exchange(waiting, 0); count > 0) reader.on_changes(std::span(changes).first(count));
  };
  while (!in.at_end()) {
    const auto start = in.position();
    const auto entry = in.byte();
    if (entry <= static_cast<std::uint8_t>(Entry::kExpired)) {
      const auto change = read_change(in, static_cast<Entry>(entry), from);
      if (in.ok()) changes[waiting++] = change;
      if (waiting == kBatch) pass_changes();
    } else if (entry == static_cast<std::uint8_t>(Entry::kRemoteSet)) {
      auto set = read_set(in, from, to);
      pass_changes();
      if (in.ok()) reader.on_set(std::move(set));
    } else if (entry == static_cast<std::uint8_t>(Entry::kReply)) {
      auto reply = read_reply(in, to);
      pass_changes();
      if (in.ok()) reader.on_reply(std::move(reply));
    } else if (entry <= static_cast<std::uint8_t>(Entry::kAnswer)) {
      const IdentityCheck check{entry == static_cast<std::uint8_t>(Entry::kAnswer), in.number()};
      pass_changes();
      if (in.ok()) reader.on_identity_check(check);
    } else if (entry == static_cast<std::uint8_t>(Entry::kTimes)) {
      const auto times = read_times(in);
      pass_changes();
      if (in.ok()) reader.on_times(times);
    } else if (entry == static_cast<std::uint8_t>(Entry::kSubscribe)) {
      auto spec = read_subscription(base::as_bytes(in.text()));
      pass_changes();
      if (!spec) in.fail_read();
      if (in.ok()) reader.on_subscription(std::move(*spec));
    } else if (entry == static_cast<std::uint8_t>(Entry::kUnsubscribe)) {
      const auto id = in.number();
      pass_changes();
      if (id > 0xffffffff) in.fail_read();
      if (in.ok()) reader.on_unsubscription(static_cast<std::uint32_t>(id));
    } else {
      in.fail_read();
    }
    if (in.ok()) continue;
    pass_changes();
    return fail(ErrorCode::kInvalid,
                fmt::format("frame from component {}: invalid entry at byte {}", model::number(from), start));
  }
  pass_changes();
  return {};
}

void FrameWriter::add(const SubscriptionSpec& spec) {
  fields_.number(spec.id);
  fields_.byte(static_cast<std::uint8_t>((spec.pattern.owner ? kOneOwner : 0) | (spec.flow.passive ? kPassive : 0)));
  if (spec.pattern.owner) fields_.number(model::number(*spec.pattern.owner));
  fields_.text(spec.pattern.key);
  fields_.signed_number(spec.flow.minimum.count());
  fields_.signed_number(spec.flow.maximum.count());
  fields_.number(std::bit_cast<std::uint64_t>(spec.flow.dead_band));
}

void FrameWriter::add_subscription(const SubscriptionSpec& spec) {
  FrameWriter content;
  content.add(spec);
  fields_.byte(static_cast<std::uint8_t>(Entry::kSubscribe));
  fields_.text(base::as_text(content.view()));
}

void FrameWriter::add_unsubscription(std::uint32_t id) {
  fields_.byte(static_cast<std::uint8_t>(Entry::kUnsubscribe));
  fields_.number(id);
}

Result<SubscriptionSpec> read_subscription(ByteView content) {
  FieldReader in(content);
  SubscriptionSpec spec;
  const auto id = in.number();
  spec.id = static_cast<std::uint32_t>(id);
  const auto bits = in.byte();
  std::optional<OwnerId> owner;
  if ((bits & kOneOwner) != 0) owner = in.owner();
  auto pattern = Pattern::parse(in.text());
  spec.flow.passive = (bits & kPassive) != 0;
  spec.flow.minimum = in.duration();
  spec.flow.maximum = in.duration();
  spec.flow.dead_band = std::bit_cast<double>(in.number());
  if (!in.ok() || !in.at_end() || id > 0xffffffff) return fail(ErrorCode::kInvalid, "subscription: malformed");
  if (!pattern) return fail(std::move(pattern.error()));
  spec.pattern = std::move(*pattern);
  spec.pattern.owner = owner;
  return spec;
}

FrameTimes FrameAges::next(Duration now, bool asks) const {
  if (!heard_) return {now, {}, {}, asks};
  return {now, heard_->sent, now - heard_->at, asks};
}

void FrameAges::arrived(const FrameTimes& times, Duration now) {
  heard_ = Heard{times.sent, now};
  if (lead_ && now - times.sent < lead_->least - slack(*lead_, now)) lead_.reset();  // the own clock stood still
  if (!times.echo) return;
  const Lead found{*times.echo + times.held - times.sent, *times.echo, now - *times.echo - times.held};
  if (!lead_ || found.least - slack(found, now) >= lead_->least - slack(*lead_, now)) lead_ = found;
}

std::optional<Duration> FrameAges::age(Duration sent, Duration now, Duration lives) const {
  if (!lead_ || slack(*lead_, now) > kMaxSlack) return std::nullopt;
  const auto most = std::max(now - sent - lead_->least + slack(*lead_, now), Duration(0));
  if (most >= lives && most - lead_->exchange < lives && lead_->exchange > kMaxSlack) return std::nullopt;
  return most;
}

}  // namespace rubicon::tuples::distant
