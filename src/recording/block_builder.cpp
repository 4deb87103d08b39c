#include "recording/block_builder.h"

#include <zstd.h>

#include <algorithm>
#include <functional>

#include "base/assert.h"
#include "recording/file_format.h"

namespace rubicon::recording {

namespace {

/// More bytes than the numbers of a record can take: eight of ten bytes and four single bytes.
constexpr std::size_t kNumbers = 96;
constexpr std::size_t kSmallTable = 1024;

std::uint8_t* put_number(std::uint8_t* to, std::uint64_t number) {
  for (; number >= 0x80; number >>= 7U) *to++ = static_cast<std::uint8_t>(number | 0x80U);
  *to++ = static_cast<std::uint8_t>(number);
  return to;
}

std::uint8_t* put_difference(std::uint8_t* to, std::int64_t value, std::int64_t from) {
  return put_number(to, zigzag(static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(from)));
}

std::uint8_t* put_text(std::uint8_t* to, std::string_view text) {
  return std::copy(text.begin(), text.end(), to);
}

std::int64_t micros(WallTime time) {
  return time.time_since_epoch().count();
}

}  // namespace

BlockBuilder::BlockBuilder(int compression)
    : compression_(std::clamp(compression, kFastest, kSmallest)),
      packer_(ZSTD_createCCtx(), [](ZSTD_CCtx_s* packer) { ZSTD_freeCCtx(packer); }),
      table_(kSmallTable) {
  RUBICON_ASSERT(packer_ != nullptr);
  clear();
}

BlockBuilder::~BlockBuilder() = default;

void BlockBuilder::clear() {
  raw_.clear();
  if (raw_.capacity() > 2 * kBlockSize) raw_.shrink_to_fit();
  if (!keys_.empty()) std::fill(table_.begin(), table_.end(), 0);
  keys_.clear();
  media_types_.assign(1, kPlainText);
  records_ = 0;
}

std::uint32_t BlockBuilder::find(std::size_t hash, std::uint32_t owner, std::string_view key) const {
  const auto mask = table_.size() - 1;
  for (auto slot = hash & mask; table_[slot] != 0; slot = (slot + 1) & mask) {
    const Known& known = keys_[table_[slot] - 1];
    if (known.hash != hash || known.owner != owner || known.size != key.size()) continue;
    if (base::as_text(ByteView(raw_).subspan(known.at, key.size())) == key) return table_[slot];
  }
  return 0;
}

void BlockBuilder::remember(const Known& known) {
  keys_.push_back(known);
  if (2 * keys_.size() > table_.size()) return grow_table();
  const auto mask = table_.size() - 1;
  auto slot = known.hash & mask;
  while (table_[slot] != 0) slot = (slot + 1) & mask;
  table_[slot] = static_cast<std::uint32_t>(keys_.size());
}

void BlockBuilder::grow_table() {
  table_.assign(2 * table_.size(), 0);
  const auto mask = table_.size() - 1;
  for (std::uint32_t number = 1; number <= keys_.size(); ++number) {
    auto slot = keys_[number - 1].hash & mask;
    while (table_[slot] != 0) slot = (slot + 1) & mask;
    table_[slot] = number;
  }
}

std::uint8_t* BlockBuilder::put_media_type(std::uint8_t* to, Known& known, std::string_view name) {
  const auto found = std::find(media_types_.begin(), media_types_.end(), name);
  const auto number = static_cast<std::uint16_t>(found - media_types_.begin());
  known.media_type = number;
  // The number after the known ones announces a new one, whose text follows.
  to = put_number(to, number);
  if (found != media_types_.end()) return to;
  media_types_.emplace_back(name);
  *to++ = static_cast<std::uint8_t>(name.size());
  return put_text(to, name);
}

bool BlockBuilder::add(const Record& record) {
  if (record.value.size() > kMaxValue || record.key.size() > kMaxKey || record.media_type.size() > kMaxMediaType)
    return false;
  const auto owner = model::number(record.owner);
  const auto hash = std::hash<std::string_view>{}(record.key) ^ owner * 0x9e3779b97f4a7c15U;
  const auto number = find(hash, owner, record.key);
  const auto seen = micros(record.seen);
  if (empty()) first_ = seen_ = seen;
  const auto start = raw_.size();
  raw_.resize(start + kNumbers + record.key.size() + record.media_type.size() + record.value.size());
  auto* const flags = raw_.data() + start;
  *flags = static_cast<std::uint8_t>(record.kind);
  auto* to = put_number(flags + 1, number);
  if (number == 0) {
    to = put_number(to, owner);
    *to++ = static_cast<std::uint8_t>(record.key.size());
    remember({hash, static_cast<std::uint32_t>(to - raw_.data()), owner, 0,
              static_cast<std::uint16_t>(record.key.size()), 0});
    to = put_text(to, record.key);
  }
  Known& known = number == 0 ? keys_.back() : keys_[number - 1];
  if (seen != seen_) {
    *flags |= kHasSeen;
    to = put_difference(to, seen, seen_);
    seen_ = seen;
  }
  to = put_number(to, zigzag(record.sequence - known.sequence - 1));
  known.sequence = record.sequence;
  to = put_difference(to, micros(record.write_time), seen);
  if (record.user_time != WallTime{}) {
    *flags |= kHasUserTime;
    to = put_difference(to, micros(record.user_time), micros(record.write_time));
  }
  if (record.expire_time != WallTime{}) {
    *flags |= kHasExpireTime;
    to = put_difference(to, micros(record.expire_time), micros(record.write_time));
  }
  if (record.creator != record.owner) {
    *flags |= kHasCreator;
    to = put_number(to, model::number(record.creator));
  }
  if (media_types_[known.media_type] != record.media_type) {
    *flags |= kHasMediaType;
    to = put_media_type(to, known, record.media_type);
  }
  to = put_text(put_number(to, record.value.size()), record.value);
  raw_.resize(static_cast<std::size_t>(to - raw_.data()));
  ++records_;
  return true;
}

ByteView BlockBuilder::close() {
  RUBICON_ASSERT(!empty());
  block_.resize(kBlockHead + ZSTD_compressBound(raw_.size()));
  const auto packed = ZSTD_compressCCtx(packer_.get(), block_.data() + kBlockHead, block_.size() - kBlockHead,
                                        raw_.data(), raw_.size(), compression_);
  RUBICON_ASSERT(ZSTD_isError(packed) == 0);
  block_.resize(kBlockHead + packed);
  const BlockHead head{
      static_cast<std::uint32_t>(packed),          static_cast<std::uint32_t>(raw_.size()), records_, first(), last(),
      crc32c(ByteView(block_).subspan(kBlockHead))};
  encode_block_head(head, block_.data());
  clear();
  return block_;
}

}  // namespace rubicon::recording
