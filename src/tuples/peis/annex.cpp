#include "tuples/peis/annex.h"

#include <bit>
#include <cmath>

#include "base/assert.h"
#include "tuples/peis/fields.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::uint64_t kPassive = std::uint64_t{1} << 47, kLongest = kPassive - 1;
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
  fields.flow.minimum = duration_of(minimum & kLongest);
  fields.flow.maximum = duration_of(maximum & kLongest);
  fields.flow.dead_band = std::bit_cast<double>(u64_at(annex, 20));
  const bool good_band = std::isfinite(fields.flow.dead_band) && fields.flow.dead_band >= 0;
  if (fields.id == 0 || maximum > kLongest || !good_band) return std::nullopt;
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
  if (fields.request == 0 || flags > kSetFlags || time_to_live > kLongest) return std::nullopt;
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

}  // namespace rubicon::tuples::peis
