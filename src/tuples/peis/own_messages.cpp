#include "tuples/peis/own_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>

#include "base/assert.h"
#include "rubicon/summary.hpp"
#include "tuples/peis/fields.h"
#include "tuples/peis/tuple_wire.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

using namespace std::chrono_literals;

constexpr std::string_view kMark = "RBC1";
constexpr Duration kMinLeaseTime = 500ms, kMaxLease = 60s;

}  // namespace

Bytes encode(const Hello& hello) {
  base::ByteWriter out;
  const auto lease = std::chrono::floor<std::chrono::milliseconds>(hello.lease).count();
  out.bytes(base::as_bytes(kMark)).u16_be(hello.version).u32_be(static_cast<std::uint32_t>(lease));
  out.u64_be(hello.incarnation)
      .bytes(base::as_bytes(hello.host_id).first(std::min(hello.host_id.size(), Hello::kMaxHostId)));
  return out.take();
}

Result<Hello> decode_hello(ByteView body) {
  base::ByteReader in(body);
  const auto mark = base::as_text(in.take(kMark.size()));
  Hello hello;
  hello.version = in.u16_be();
  const auto lease = std::chrono::milliseconds(in.u32_be());
  hello.incarnation = in.u64_be();
  if (!in.ok() || mark != kMark || hello.version == 0) return fail(ErrorCode::kInvalid, "hello: no mark, or too short");
  const auto rest = base::as_text(in.take(in.remaining()));
  hello.host_id = rest.substr(0, std::min(rest.find('\0'), Hello::kMaxHostId));
  hello.lease = std::clamp<Duration>(lease, kMinLeaseTime, kMaxLease);
  return hello;
}

std::string kernel_summary(const Identity& host) {
  Summary summary;
  summary.name = host.full_name.substr(0, host.full_name.find('@'));
  summary.host = host.host_name;
  summary.program = fmt::format("peis-kernel {}", kProtocolVersion);
  return model::to_json(summary);
}

namespace {

constexpr std::uint64_t kPassive = std::uint64_t{1} << 47, kMaxMicroseconds = kPassive - 1;
constexpr std::uint16_t kHasTimeToLive = 1, kHasSequence = 2, kGiven = 4, kAppend = 8, kNoMediaType = 16;
constexpr std::uint16_t kSetFlags = 31;
constexpr std::uint16_t kIsDeleted = 1, kIsExpired = 2, kHasNoMediaType = 4;

Annex marked() {
  Annex annex{};
  put_bytes(annex, 0, kAnnexMark);
  return annex;
}

bool is_marked(const Annex& annex) {
  return std::equal(kAnnexMark.begin(), kAnnexMark.end(), annex.begin());
}

void put_u48(std::span<std::uint8_t> annex, std::size_t at, std::uint64_t value) {
  put_u16(annex, at, static_cast<std::uint16_t>(value >> 32));
  put_u32(annex, at + 2, static_cast<std::uint32_t>(value & 0xffffffff));
}
std::uint64_t u48_at(const Annex& annex, std::size_t at) {
  return std::uint64_t{u16_at(annex, at)} << 32 | u32_at(annex, at + 2);
}

std::uint64_t microseconds_of(Duration duration) {
  const auto limited = std::clamp(duration, Duration(0), kMaxAnnexDuration);
  return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(limited).count());
}
Duration duration_of(std::uint64_t microseconds) {
  return std::chrono::microseconds(static_cast<std::int64_t>(microseconds));
}

}  // namespace

Annex to_annex(const SubscribeAnnex& fields) {
  RUBICON_ASSERT(fields.id != 0);
  auto annex = marked();
  put_u32(annex, 4, fields.id);
  put_u48(annex, 8, microseconds_of(fields.flow.minimum) | (fields.flow.passive ? kPassive : 0));
  put_u48(annex, 14, microseconds_of(fields.flow.maximum));
  const auto band = fields.flow.dead_band;
  put_u64(annex, 20, std::bit_cast<std::uint64_t>(std::isfinite(band) && band > 0 ? band : 0.0));
  return annex;
}

std::optional<SubscribeAnnex> read_subscribe_annex(const Annex& annex) {
  if (!is_marked(annex)) return std::nullopt;
  SubscribeAnnex fields;
  fields.id = u32_at(annex, 4);
  const auto minimum = u48_at(annex, 8), maximum = u48_at(annex, 14);
  fields.flow.passive = (minimum & kPassive) != 0;
  fields.flow.minimum = duration_of(minimum & kMaxMicroseconds);
  fields.flow.maximum = duration_of(maximum & kMaxMicroseconds);
  fields.flow.dead_band = std::bit_cast<double>(u64_at(annex, 20));
  const bool good_band = std::isfinite(fields.flow.dead_band) && fields.flow.dead_band >= 0;
  if (fields.id == 0 || maximum > kMaxMicroseconds || !good_band) return std::nullopt;
  return fields;
}

Annex to_annex(const SetAnnex& fields) {
  RUBICON_ASSERT(fields.request != 0);
  auto annex = marked();
  put_u64(annex, 4, fields.request);
  std::uint16_t flags = 0;
  if (fields.time_to_live) flags |= kHasTimeToLive;
  if (fields.expected_sequence) flags |= kHasSequence;
  if (fields.time_to_live_given) flags |= kGiven;
  if (fields.append) flags |= kAppend;
  if (fields.no_media_type) flags |= kNoMediaType;
  put_u16(annex, 12, flags);
  put_u48(annex, 14, microseconds_of(fields.time_to_live.value_or(Duration(0))));
  put_u64(annex, 20, fields.expected_sequence.value_or(0));
  return annex;
}

std::optional<SetAnnex> read_set_annex(const Annex& annex) {
  if (!is_marked(annex)) return std::nullopt;
  SetAnnex fields;
  fields.request = u64_at(annex, 4);
  const auto flags = u16_at(annex, 12);
  const auto time_to_live = u48_at(annex, 14);
  if (fields.request == 0 || flags > kSetFlags || time_to_live > kMaxMicroseconds) return std::nullopt;
  if ((flags & kHasTimeToLive) != 0) fields.time_to_live = duration_of(time_to_live);
  if ((flags & kHasSequence) != 0) fields.expected_sequence = u64_at(annex, 20);
  fields.time_to_live_given = (flags & kGiven) != 0;
  fields.append = (flags & kAppend) != 0;
  fields.no_media_type = (flags & kNoMediaType) != 0;
  return fields;
}

void put_time_to_live(std::span<std::uint8_t> set_remote, Duration remaining) {
  constexpr std::size_t kOffset = 48;
  const auto annex = set_remote.subspan(kOffset, Annex{}.size());
  put_u48(annex, 14, microseconds_of(remaining));
}

Annex to_annex(const PushAnnex& fields) {
  auto annex = marked();
  std::uint16_t flags = 0;
  if (fields.kind == EventKind::kDeleted) flags |= kIsDeleted;
  if (fields.kind == EventKind::kExpired) flags |= kIsExpired;
  if (fields.no_media_type) flags |= kHasNoMediaType;
  put_u16(annex, 4, flags);
  put_u64(annex, 8, fields.sequence);
  return annex;
}

std::optional<PushAnnex> read_push_annex(const Annex& annex) {
  if (!is_marked(annex)) return std::nullopt;
  const auto flags = u16_at(annex, 4);
  const bool is_deleted = (flags & kIsDeleted) != 0, is_expired = (flags & kIsExpired) != 0;
  if (flags > (kIsDeleted | kIsExpired | kHasNoMediaType) || (is_deleted && is_expired)) return std::nullopt;
  const auto kind = is_deleted ? EventKind::kDeleted : is_expired ? EventKind::kExpired : EventKind::kSet;
  return PushAnnex{u64_at(annex, 8), kind, (flags & kHasNoMediaType) != 0};
}

namespace {

constexpr std::size_t kReplySize = 22, kControlSize = 8;
constexpr std::uint8_t kSnapshotEnd = 1, kRestart = 2, kForget = 3;

Bytes marked_body(std::size_t size) {
  Bytes out(size);
  put_bytes(out, 0, kAnnexMark);
  return out;
}

Result<void> check_mark(std::string_view body, ByteView bytes, std::size_t size) {
  if (bytes.size() < size) return wrong_field(body, fmt::format("{} bytes, expected at least {}", bytes.size(), size));
  if (!std::equal(kAnnexMark.begin(), kAnnexMark.end(), bytes.begin()))
    return wrong_field(body, "another mark, expected RBC1");
  return {};
}

}  // namespace

Bytes write_reply(const Reply& reply) {
  auto out = marked_body(kReplySize);
  put_u64(out, 4, reply.request);
  put_u64(out, 12, reply.sequence);
  out[20] = static_cast<std::uint8_t>(reply.verdict);
  out[21] = static_cast<std::uint8_t>(reply.code);
  out.insert(out.end(), reply.text.begin(), reply.text.end());
  return out;
}

Result<Reply> read_reply(ByteView body) {
  constexpr std::string_view kBody = "REPLY";
  if (const auto good = check_mark(kBody, body, kReplySize); !good) return fail(good.error());
  if (body[20] > static_cast<std::uint8_t>(Verdict::kNoSuchOwner))
    return wrong_field(kBody, fmt::format("verdict at 20: {}, expected at most 3", body[20]));
  if (body[21] > static_cast<std::uint8_t>(ErrorCode::kIo))
    return wrong_field(kBody, fmt::format("error code at 21: {}, expected at most 9", body[21]));
  Reply reply;
  reply.request = u64_at(body, 4);
  reply.sequence = u64_at(body, 12);
  reply.verdict = Verdict(body[20]);
  reply.code = ErrorCode(body[21]);
  reply.text = base::as_text(body.subspan(kReplySize));
  return reply;
}

Bytes write_control(const SnapshotEnd& end) {
  auto out = marked_body(kControlSize + 4);
  out[4] = kSnapshotEnd;
  put_u32(out, kControlSize, end.subscription);
  return out;
}

Bytes write_control(const Restart& restart) {
  auto out = marked_body(kControlSize + 8);
  out[4] = kRestart;
  put_u64(out, kControlSize, static_cast<std::uint64_t>(restart.since.time_since_epoch().count()));
  return out;
}

Bytes write_forget() {
  auto out = marked_body(kControlSize);
  out[4] = kForget;
  return out;
}

bool is_forget(ByteView body) {
  return check_mark("SNAPSHOT", body, kControlSize) && body.size() == kControlSize && body[4] == kForget;
}

Result<Change> read_control(ByteView body) {
  constexpr std::string_view kBody = "SNAPSHOT";
  if (const auto good = check_mark(kBody, body, kControlSize); !good) return fail(good.error());
  const bool is_end = body[4] == kSnapshotEnd;
  if (!is_end && body[4] != kRestart) return wrong_field(kBody, fmt::format("kind at 4: {}, expected 1 or 2", body[4]));
  if (const auto size = expect_size(kBody, body, kControlSize + (is_end ? 4 : 8)); !size) return fail(size.error());
  if (is_end) return SnapshotEnd{u32_at(body, kControlSize)};
  const auto since = static_cast<std::int64_t>(u64_at(body, kControlSize));
  return Restart{WallTime(std::chrono::microseconds(since))};
}

}  // namespace rubicon::tuples::peis
