#include "recording/block.h"

#include <algorithm>
#include <string_view>

#include "recording/crc32c.h"
#include "recording/little_endian.h"

namespace rubicon::recording {

namespace {

constexpr std::size_t kHeadSum = 40;  ///< offset of the head's own check sum

WallTime time_at(const std::uint8_t* from) {
  return WallTime(std::chrono::microseconds(get_le<std::int64_t>(from)));
}

}  // namespace

void encode_block_head(const BlockHead& head, std::uint8_t* to) {
  std::copy(kSync.begin(), kSync.end(), to);
  put_le(to + 8, head.packed);
  put_le(to + 12, head.raw);
  put_le(to + 16, head.records);
  put_le(to + 20, head.first.time_since_epoch().count());
  put_le(to + 28, head.last.time_since_epoch().count());
  put_le(to + 36, head.sum);
  put_le(to + kHeadSum, crc32c({to, kHeadSum}));
}

std::optional<BlockHead> decode_block_head(ByteView bytes) {
  if (bytes.size() < kBlockHead || !std::equal(kSync.begin(), kSync.end(), bytes.begin())) return std::nullopt;
  const auto* from = bytes.data();
  if (get_le<std::uint32_t>(from + kHeadSum) != crc32c(bytes.first(kHeadSum))) return std::nullopt;
  BlockHead head;
  head.packed = get_le<std::uint32_t>(from + 8);
  head.raw = get_le<std::uint32_t>(from + 12);
  head.records = get_le<std::uint32_t>(from + 16);
  head.first = time_at(from + 20);
  head.last = time_at(from + 28);
  head.sum = get_le<std::uint32_t>(from + 36);
  const bool bounded = head.packed > 0 && head.packed <= kMaxPacked && head.raw > 0 && head.raw <= kMaxRaw;
  if (!bounded || head.records == 0 || head.records > head.raw) return std::nullopt;
  return head;
}

std::size_t sound_block(ByteView bytes) {
  const auto head = decode_block_head(bytes);
  if (!head || bytes.size() - kBlockHead < head->packed) return 0;
  return crc32c(bytes.subspan(kBlockHead, head->packed)) == head->sum ? kBlockHead + head->packed : 0;
}

std::size_t find_sync(ByteView bytes, std::size_t from) {
  const auto found = base::as_text(bytes).find(base::as_text(kSync), from);
  return found == std::string_view::npos ? bytes.size() : found;
}

}  // namespace rubicon::recording
