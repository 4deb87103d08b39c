#include "recording/file_format.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace rubicon::recording {

namespace {

constexpr std::uint32_t kReflected = 0x82f63b78;
using Table = std::array<std::array<std::uint32_t, 256>, 8>;

/// Eight bytes a step: row n holds the remainders of a byte that is followed by n zero bytes.
constexpr Table make_table() {
  Table table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1U) ^ ((rest & 1U) != 0 ? kReflected : 0U);
    table[0][byte] = rest;
  }
  for (std::size_t row = 1; row < 8; ++row) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = table[row - 1][byte];
      table[row][byte] = (before >> 8U) ^ table[0][before & 0xffU];
    }
  }
  return table;
}

constexpr Table kTable = make_table();

}  // namespace

std::uint32_t crc32c(ByteView bytes) {
  std::uint32_t rest = 0xffffffff;
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    const std::uint8_t* p = bytes.data() + at;
    const std::uint32_t low = rest ^ (std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8U | std::uint32_t{p[2]} << 16U |
                                      std::uint32_t{p[3]} << 24U);
    rest = kTable[7][low & 0xffU] ^ kTable[6][(low >> 8U) & 0xffU] ^ kTable[5][(low >> 16U) & 0xffU] ^
           kTable[4][low >> 24U] ^ kTable[3][p[4]] ^ kTable[2][p[5]] ^ kTable[1][p[6]] ^ kTable[0][p[7]];
  }
  for (; at < bytes.size(); ++at) rest = (rest >> 8U) ^ kTable[0][(rest ^ bytes[at]) & 0xffU];
  return ~rest;
}

namespace {

constexpr std::size_t kFixed = 4 + 8;  ///< island, created
constexpr std::size_t kCrc = 4;

void put_text(Bytes& to, std::string_view text) {
  text = text.substr(0, 255);
  to.push_back(static_cast<std::uint8_t>(text.size()));
  to.insert(to.end(), text.begin(), text.end());
}

std::optional<std::string> take_text(base::ByteReader& reader) {
  const auto text = reader.take(reader.u8());
  if (!reader.ok()) return std::nullopt;
  return std::string(base::as_text(text));
}

}  // namespace

Bytes encode_head(const FileHead& head) {
  Bytes out(kMagic.begin(), kMagic.end());
  out.resize(kHeadStart + kFixed);
  put_le(&out[8], kVersion);
  put_le(&out[12], model::number(head.island));
  put_le(&out[16], head.created.time_since_epoch().count());
  put_text(out, head.prefix);
  put_text(out, head.writer);
  out.resize(out.size() + kCrc);
  put_le(&out[10], static_cast<std::uint16_t>(out.size() - kHeadStart));
  put_le(&out[out.size() - kCrc], crc32c(ByteView(out).first(out.size() - kCrc)));
  return out;
}

HeadFound decode_head(ByteView bytes) {
  const auto magic = std::min(bytes.size(), kMagic.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(magic), kMagic.begin())) return {};
  if (bytes.size() < kHeadStart) return {HeadState::kIncomplete, {}, 0};
  const auto version = get_le<std::uint16_t>(&bytes[8]);
  const std::size_t size = kHeadStart + get_le<std::uint16_t>(&bytes[10]);
  if (size > kMaxHead || size < kHeadStart + kFixed + 2 + kCrc) return {HeadState::kDamaged, {}, 0};
  if (bytes.size() < size) return {HeadState::kIncomplete, {}, 0};
  const auto sum = get_le<std::uint32_t>(&bytes[size - kCrc]);
  if (sum != crc32c(bytes.first(size - kCrc))) return {HeadState::kDamaged, {}, 0};
  if (version != kVersion) return {HeadState::kNewer, {}, size};
  HeadFound found{HeadState::kSound, {}, size};
  found.head.island = IslandId(get_le<std::uint32_t>(&bytes[12]));
  found.head.created = WallTime(std::chrono::microseconds(get_le<std::int64_t>(&bytes[16])));
  base::ByteReader rest(bytes.first(size - kCrc).subspan(kHeadStart + kFixed));
  const auto prefix = take_text(rest);
  const auto writer = take_text(rest);
  if (!prefix || !writer) return {HeadState::kDamaged, {}, 0};
  found.head.prefix = *prefix;
  found.head.writer = *writer;
  return found;
}

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
