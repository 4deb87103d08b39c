#include "recording/file_tail.h"

#include <algorithm>

#include "recording/block.h"

namespace rubicon::recording {

namespace {

/// Marker positions looked at in one step backwards.
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

/// End of the last sound block that begins in the first `starts` bytes; 0 if there is none.
std::size_t last_sound_end(ByteView bytes, std::size_t starts) {
  std::size_t end = 0;
  for (auto at = find_sync(bytes, 0); at < starts; at = find_sync(bytes, at + 1)) {
    const auto size = sound_block(bytes.subspan(at));
    if (size != 0) end = std::max(end, at + size);
  }
  return end;
}

}  // namespace

Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read) {
  auto beginning = read_range(read, 0, std::min<std::uint64_t>(size, kMaxHead));
  if (!beginning) return fail(beginning.error());
  FileTail tail;
  auto found = decode_head(*beginning);
  switch (found.state) {
    case HeadState::kIncomplete: return tail;
    case HeadState::kNoRecording: return fail(ErrorCode::kInvalid, "is no recording");
    case HeadState::kDamaged: return fail(ErrorCode::kInvalid, "is a recording whose head is damaged");
    case HeadState::kNewer: return fail(ErrorCode::kUnsupported, "is a recording of a newer version");
    case HeadState::kSound: break;
  }
  tail.has_head = true;
  tail.head = std::move(found.head);
  tail.sound = found.size;
  for (std::uint64_t high = size; high > found.size;) {
    const auto low = std::max<std::uint64_t>(found.size, high - std::min(high, kStride));
    // A block that begins below `high` may reach beyond it.
    const auto bytes = read_range(read, low, std::min<std::uint64_t>(size, high + kMaxBlock));
    if (!bytes) return fail(bytes.error());
    if (const auto end = last_sound_end(*bytes, static_cast<std::size_t>(high - low)); end != 0) {
      tail.sound = low + end;
      return tail;
    }
    high = low;
  }
  return tail;
}

}  // namespace rubicon::recording
