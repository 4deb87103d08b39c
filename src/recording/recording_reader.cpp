#include "recording/recording_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "base/assert.h"
#include "recording/crc32c.h"

namespace rubicon::recording {

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

}  // namespace rubicon::recording
