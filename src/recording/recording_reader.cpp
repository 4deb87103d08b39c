#include "recording/recording_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "base/assert.h"
#include "recording/file_format.h"

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

RecordingReader::RecordingReader(std::size_t budget)
    : budget_(budget), unpacker_(ZSTD_createDCtx(), [](ZSTD_DCtx_s* unpacker) { ZSTD_freeDCtx(unpacker); }) {
  RUBICON_ASSERT(unpacker_ != nullptr);
}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

void RecordingReader::feed(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(position_));
  base_ += position_;
  position_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<RecordingReader::Item> RecordingReader::next() {
  work_ = 0;
  busy_ = false;
  for (;;) {
    if (records_) {
      if (auto record = take_record()) return record;
    }
    if (found_) {
      // Damage before it comes first.
      if (auto damage = take_damage()) return damage;
      if (std::holds_alternative<BlockFound>(*found_)) records_.emplace(head_, raw_);
      return std::exchange(found_, std::nullopt);
    }
    if (work_ > budget_) {
      busy_ = true;
      return std::nullopt;
    }
    if (parse() == Progress::kNeedsBytes) return ended_ ? take_damage() : std::nullopt;
  }
}

std::optional<RecordingReader::Item> RecordingReader::take_record() {
  if (auto record = records_->next()) return *record;
  const auto fault = records_->fault();
  if (fault.empty()) {
    records_.reset();
    return std::nullopt;
  }
  Damage damage{offset_, end_of_block_ - offset_, fmt::format("a block with {}", fault)};
  records_.reset();
  return damage;
}

std::optional<RecordingReader::Item> RecordingReader::take_damage() {
  if (!damage_) return std::nullopt;
  Item item = std::move(*damage_);
  damage_.reset();
  return item;
}

BlockDecoder RecordingReader::block() const {
  return {head_, raw_};
}

/// Parses at the present position.
RecordingReader::Progress RecordingReader::parse() {
  const auto rest = ByteView(buffer_).subspan(position_);
  work_ += kBlockHead;
  if (rest.empty() || (rest.size() < kSync.size() && !ended_)) return Progress::kNeedsBytes;
  const auto begins = [&rest](const auto& with) {
    return rest.size() >= with.size() && std::equal(with.begin(), with.end(), rest.begin());
  };
  if (begins(kSync)) return parse_block(rest);
  if (begins(kMagic)) return parse_head(rest);
  const auto sync = find_sync(rest, 0);
  work_ += sync;
  const bool none = sync == rest.size();
  // The bytes may end within a marker.
  const auto keep = none && !ended_ ? kSync.size() - 1 : 0;
  return skip(sync - keep, base_ + position_ == 0 ? "no recording begins here" : "no block begins here");
}

RecordingReader::Progress RecordingReader::skip(std::size_t bytes, std::string_view why) {
  if (bytes == 0) return Progress::kNeedsBytes;
  if (!damage_) damage_ = Damage{base_ + position_, 0, std::string(why)};
  damage_->bytes += bytes;
  position_ += bytes;
  return Progress::kMade;
}

RecordingReader::Progress RecordingReader::parse_head(ByteView rest) {
  auto found = decode_head(rest.first(std::min(rest.size(), kMaxHead)));
  switch (found.state) {
    case HeadState::kSound:
      position_ += found.size;
      found_ = std::move(found.head);
      return Progress::kMade;
    case HeadState::kIncomplete:
      if (!ended_) return Progress::kNeedsBytes;
      return skip(kMagic.size(), "the head of the recording is cut short");
    case HeadState::kNewer: return skip(kMagic.size(), "the recording is of a newer version");
    case HeadState::kNoRecording:
    case HeadState::kDamaged: break;
  }
  return skip(kMagic.size(), "the head of the recording is damaged");
}

RecordingReader::Progress RecordingReader::parse_block(ByteView rest) {
  if (rest.size() < kBlockHead) {
    if (!ended_) return Progress::kNeedsBytes;
    return skip(kSync.size(), "the head of a block is cut short");
  }
  const auto head = decode_block_head(rest);
  if (!head) return skip(kSync.size(), "the head of a block is damaged");
  if (rest.size() - kBlockHead < head->packed) {
    if (!ended_) return Progress::kNeedsBytes;
    return skip(kSync.size(), "a block is cut short");
  }
  const auto packed = rest.subspan(kBlockHead, head->packed);
  work_ += packed.size();
  if (crc32c(packed) != head->sum) return skip(kSync.size(), "the check sum of a block is wrong");
  if (!unpack(*head, packed)) return skip(kSync.size(), "a block cannot be unpacked");
  offset_ = base_ + position_;
  position_ += kBlockHead + head->packed;
  end_of_block_ = base_ + position_;
  head_ = *head;
  found_ = BlockFound{offset_, head_};
  return Progress::kMade;
}

bool RecordingReader::unpack(const BlockHead& head, ByteView packed) {
  raw_.resize(head.raw);
  work_ += head.raw;
  const auto size = ZSTD_decompressDCtx(unpacker_.get(), raw_.data(), raw_.size(), packed.data(), packed.size());
  return ZSTD_isError(size) == 0 && size == head.raw;
}

namespace {

constexpr std::size_t kPieceBytes = 64 << 10;

}  // namespace

Result<void> each_item(const ReadPiece& read, const VisitItem& visit) {
  RecordingReader reader;
  Bytes piece(kPieceBytes);
  while (!reader.ended()) {
    const auto count = read(piece);
    if (!count) return fail(count.error());
    if (*count == 0) reader.end();
    if (*count > 0) reader.feed(ByteView(piece).first(*count));
    while (const auto item = reader.next()) {
      if (auto visited = visit(*item); !visited) return visited;
    }
  }
  return {};
}

namespace {

/// Bytes searched for markers in one step backwards.
constexpr std::uint64_t kStride = 512 << 10;

Result<Bytes> read_range(const ReadAt& read, std::uint64_t from, std::uint64_t to) {
  Bytes bytes(static_cast<std::size_t>(to - from));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const auto count = read(from + filled, std::span(bytes).subspan(filled));
    if (!count) return fail(count.error());
    if (*count == 0) break;
    filled += *count;
  }
  bytes.resize(filled);
  return bytes;
}

/// Bytes checked without success. Without a limit many heads of long blocks in a row would each cause a long check.
constexpr std::uint64_t kMaxChecked = 64 << 20;

/// A sound block: its end, 0 = there is none.
struct SoundBlock {
  std::size_t end = 0;
  WallTime last{};
};

/// The last sound block that begins in the first `starts` bytes; none also if `checked` is used up.
SoundBlock last_sound_block(ByteView bytes, std::size_t starts, std::uint64_t& checked) {
  SoundBlock found;
  for (auto at = find_sync(bytes, 0); at < starts && checked < kMaxChecked; at = find_sync(bytes, at + 1)) {
    const auto head = decode_block_head(bytes.subspan(at));
    if (!head) continue;
    checked += head->packed;
    const auto size = sound_block(bytes.subspan(at));
    if (size == 0) continue;
    if (at + size > found.end) found = {at + size, head->last};
    checked -= head->packed;
  }
  return found;
}

}  // namespace

Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read) {
  auto beginning = read_range(read, 0, std::min<std::uint64_t>(size, kMaxHead));
  if (!beginning) return fail(beginning.error());
  FileTail tail;
  auto found = decode_head(*beginning);
  switch (found.state) {
    case HeadState::kIncomplete: return tail;
    case HeadState::kNoRecording: return fail(ErrorCode::kInvalid, "is not a recording");
    case HeadState::kDamaged: return fail(ErrorCode::kInvalid, "is a recording whose head is damaged");
    case HeadState::kNewer: return fail(ErrorCode::kUnsupported, "is a recording of a newer version");
    case HeadState::kSound: break;
  }
  tail.has_head = true;
  tail.head = std::move(found.head);
  tail.sound = found.size;
  std::uint64_t checked = 0;
  for (std::uint64_t high = size; high > found.size;) {
    const auto low = std::max<std::uint64_t>(found.size, high - std::min(high, kStride));
    // A block that begins before `high` may end after it.
    const auto bytes = read_range(read, low, std::min<std::uint64_t>(size, high + kMaxBlock));
    if (!bytes) return fail(bytes.error());
    const auto [end, last] = last_sound_block(*bytes, static_cast<std::size_t>(high - low), checked);
    const bool given_up = checked >= kMaxChecked || (end == 0 && low > found.size && size - low >= kMaxTail);
    if (given_up) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("byte {}: no sound block in the last {} bytes, expected one (the file is left as it is)",
                              low, size - low));
    }
    if (end != 0) {
      tail.sound = low + end;
      tail.last = last;
      return tail;
    }
    high = low;
  }
  return tail;
}

}  // namespace rubicon::recording
