#include "recording/file_tail.h"

#include <fmt/format.h>

#include <algorithm>

#include "recording/block.h"

namespace rubicon::recording {

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
