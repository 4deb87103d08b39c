#include "tuples/dds/frame_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace rubicon::tuples::dds {

namespace {

enum class Entry : std::uint8_t { kSet, kDeleted, kExpired, kRemoteSet, kReply, kQuestion, kAnswer };

// Bits of a remote set.
constexpr std::uint8_t kAppend = 1, kTimeToLiveGiven = 2, kExpectsSequence = 4;
// Bits of a subscription.
constexpr std::uint8_t kOneOwner = 1, kPassive = 2;

constexpr std::int64_t kMaxDuration = std::chrono::nanoseconds(std::chrono::years(100)).count();

std::int64_t micros(WallTime time) {
  return time.time_since_epoch().count();
}

/// Reads what FrameWriter wrote. After an invalid read all further ones give zero.
class Cursor {
 public:
  explicit Cursor(ByteView bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (at_ >= bytes_.size()) return fail_read();
    return bytes_[at_++];
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto part = byte();
      value |= static_cast<std::uint64_t>(part & 0x7f) << shift;
      if ((part & 0x80) == 0) return shift == 63 && part > 1 ? fail_read() : value;
    }
    return fail_read();
  }
  std::int64_t signed_number() {
    const auto value = number();
    return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
  }
  std::string_view text() {
    const auto size = number();
    if (size > bytes_.size() - at_) return fail_read(), std::string_view();
    const auto found = base::as_text(bytes_.subspan(at_, static_cast<std::size_t>(size)));
    at_ += static_cast<std::size_t>(size);
    return found;
  }
  WallTime time() { return WallTime(std::chrono::microseconds(signed_number())); }
  /// Clamped to 0..100 years.
  Duration duration() { return Duration(std::clamp<std::int64_t>(signed_number(), 0, kMaxDuration)); }
  OwnerId owner() {
    const auto id = number();
    if (id > 0xffffffff) fail_read();
    return OwnerId(static_cast<std::uint32_t>(id));
  }

  bool ok() const { return ok_; }
  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t position() const { return at_; }
  std::uint8_t fail_read() {
    ok_ = false;
    at_ = bytes_.size();
    return 0;
  }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// In an entry kSet with an empty key the sequence is the id of the subscription whose snapshot ends, or 0 for Restart,
/// with its time as the write time.
Change read_set_entry(Cursor& in, OwnerId from) {
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

Change read_change(Cursor& in, Entry entry, OwnerId from) {
  if (entry == Entry::kSet) return read_set_entry(in, from);
  TupleGone gone;
  gone.how = entry == Entry::kExpired ? EventKind::kExpired : EventKind::kDeleted;
  gone.key = in.text();
  gone.sequence = in.number();
  return gone;
}

RemoteSet read_set(Cursor& in, OwnerId from, OwnerId to) {
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
  return set;
}

Reply read_reply(Cursor& in, OwnerId to) {
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

}  // namespace

void FrameWriter::number(std::uint64_t value) {
  while (value >= 0x80) {
    byte(static_cast<std::uint8_t>(value | 0x80));
    value >>= 7;
  }
  byte(static_cast<std::uint8_t>(value));
}

void FrameWriter::signed_number(std::int64_t value) {
  number((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
}

void FrameWriter::text(std::string_view text) {
  number(text.size());
  add(base::as_bytes(text));
}

void FrameWriter::add(ByteView entries) {
  bytes_.insert(bytes_.end(), entries.begin(), entries.end());
}

void FrameWriter::add(const Change& change) {
  if (const auto* set = std::get_if<TupleSet>(&change)) return set_entry(set->tuple);
  if (const auto* gone = std::get_if<TupleGone>(&change)) {
    byte(static_cast<std::uint8_t>(gone->how == EventKind::kExpired ? Entry::kExpired : Entry::kDeleted));
    text(gone->key);
    number(gone->sequence);
    return;
  }
  TupleView control;
  if (const auto* end = std::get_if<SnapshotEnd>(&change)) control.sequence = end->subscription;
  if (const auto* restart = std::get_if<Restart>(&change)) control.write_time = restart->since;
  set_entry(control);
}

void FrameWriter::set_entry(const TupleView& tuple) {
  byte(static_cast<std::uint8_t>(Entry::kSet));
  text(tuple.key);
  number(tuple.sequence);
  text(tuple.value);
  text(tuple.media_type);
  number(model::number(tuple.creator));
  signed_number(micros(tuple.write_time));
  signed_number(micros(tuple.user_time));
  signed_number(micros(tuple.expire_time));
}

void FrameWriter::add(const RemoteSet& set) {
  byte(static_cast<std::uint8_t>(Entry::kRemoteSet));
  number(set.request);
  text(set.key);
  text(set.value);
  text(set.media_type);
  signed_number(micros(set.user_time));
  signed_number(set.lifetime.count());
  signed_number(set.time_to_live.count());
  std::uint8_t bits = 0;
  if (set.append) bits |= kAppend;
  if (set.time_to_live_given) bits |= kTimeToLiveGiven;
  if (set.expected_sequence) bits |= kExpectsSequence;
  byte(bits);
  if (set.expected_sequence) number(*set.expected_sequence);
}

void FrameWriter::add(const Reply& reply) {
  byte(static_cast<std::uint8_t>(Entry::kReply));
  number(reply.request);
  byte(static_cast<std::uint8_t>(reply.verdict));
  byte(static_cast<std::uint8_t>(reply.code));
  text(reply.text);
  number(reply.sequence);
}

void FrameWriter::add(const IdentityCheck& check) {
  byte(static_cast<std::uint8_t>(check.is_answer ? Entry::kAnswer : Entry::kQuestion));
  number(check.number);
}

Result<void> read_frame(ByteView frame, OwnerId from, OwnerId to, FrameReader& reader) {
  Cursor in(frame);
  std::vector<Change> changes;
  const auto pass_changes = [&] {
    if (!changes.empty()) reader.on_changes(changes);
    changes.clear();
  };
  while (!in.at_end()) {
    const auto start = in.position();
    const auto entry = in.byte();
    if (entry <= static_cast<std::uint8_t>(Entry::kExpired)) {
      const auto change = read_change(in, static_cast<Entry>(entry), from);
      if (in.ok()) changes.push_back(change);
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
  number(spec.id);
  byte(static_cast<std::uint8_t>((spec.pattern.owner ? kOneOwner : 0) | (spec.flow.passive ? kPassive : 0)));
  if (spec.pattern.owner) number(model::number(*spec.pattern.owner));
  text(spec.pattern.key);
  signed_number(spec.flow.minimum.count());
  signed_number(spec.flow.maximum.count());
  number(std::bit_cast<std::uint64_t>(spec.flow.dead_band));
}

Result<SubscriptionSpec> read_subscription(ByteView content) {
  Cursor in(content);
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

}  // namespace rubicon::tuples::dds
