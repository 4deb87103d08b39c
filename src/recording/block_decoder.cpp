#include "recording/block_decoder.h"

#include <algorithm>

#include "recording/record_layout.h"

namespace rubicon::recording {

namespace {

WallTime wall(std::int64_t micros) {
  return WallTime(std::clamp(std::chrono::microseconds(micros), -kFurthest, kFurthest));
}

}  // namespace

BlockDecoder::BlockDecoder(const BlockHead& head, ByteView raw)
    : at_(raw.data()),
      end_(raw.data() + raw.size()),
      left_(head.records),
      seen_(head.first.time_since_epoch().count()),
      media_types_(1, kPlainText) {}

std::uint8_t BlockDecoder::byte() {
  if (at_ != end_) return *at_++;
  truncated_ = true;
  return 0;
}

std::uint64_t BlockDecoder::number() {
  std::uint64_t sum = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const std::uint8_t part = byte();
    sum |= static_cast<std::uint64_t>(part & 0x7fU) << shift;
    if ((part & 0x80U) == 0) return sum;
  }
  truncated_ = true;  // no number is that long
  return 0;
}

std::string_view BlockDecoder::text(std::size_t size) {
  if (size > static_cast<std::size_t>(end_ - at_)) {
    truncated_ = true;
    return {};
  }
  const std::string_view found(reinterpret_cast<const char*>(at_), size);
  at_ += size;
  return found;
}

std::int64_t BlockDecoder::after(std::int64_t time) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(time) + from_zigzag(number()));
}

std::optional<Record> BlockDecoder::stop(std::string_view why) {
  fault_ = why;
  left_ = 0;
  at_ = end_;
  return std::nullopt;
}

BlockDecoder::Known* BlockDecoder::key_of(Record& record) {
  const auto place = number();
  if (place > keys_.size()) return nullptr;
  if (place == 0) {
    const auto owner = number();
    if (owner > 0xffffffffU) return nullptr;
    keys_.push_back({OwnerId(static_cast<std::uint32_t>(owner)), text(byte()), 0, 0});
  }
  record.key_number = static_cast<std::uint32_t>(place == 0 ? keys_.size() - 1 : place - 1);
  return &keys_[record.key_number];
}

void BlockDecoder::read_media_type(Known& known) {
  const auto place = number();
  if (place > media_types_.size()) {
    truncated_ = true;
    return;
  }
  if (place == media_types_.size()) media_types_.push_back(text(byte()));
  known.media_type = static_cast<std::size_t>(place);
}

std::optional<Record> BlockDecoder::next() {
  if (left_ == 0) {
    if (at_ != end_) return stop("bytes after the last record");
    return std::nullopt;
  }
  Record record;
  const auto flags = byte();
  record.kind = static_cast<RecordKind>(flags & kKindBits);
  if (record.kind > RecordKind::kMark) return stop("a record of an unknown kind");
  auto* known = key_of(record);
  if (known == nullptr) return stop("a record of a key that was not named");
  if ((flags & kHasSeen) != 0) seen_ = after(seen_);
  record.seen = wall(seen_);
  record.owner = known->owner;
  record.key = known->key;
  record.sequence = known->sequence + 1 + from_zigzag(number());
  known->sequence = record.sequence;
  const auto write = after(seen_);
  record.write_time = wall(write);
  if ((flags & kHasUserTime) != 0) record.user_time = wall(after(write));
  if ((flags & kHasExpireTime) != 0) record.expire_time = wall(after(write));
  record.creator = record.owner;
  if ((flags & kHasCreator) != 0) record.creator = OwnerId(static_cast<std::uint32_t>(number()));
  if ((flags & kHasMediaType) != 0) read_media_type(*known);
  record.media_type = media_types_[known->media_type];
  record.value = text(number());
  if (truncated_) return stop("a record that does not end in its block");
  --left_;
  return record;
}

}  // namespace rubicon::recording
