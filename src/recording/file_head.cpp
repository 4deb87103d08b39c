#include "recording/file_head.h"

#include <algorithm>

#include "recording/crc32c.h"
#include "recording/little_endian.h"

namespace rubicon::recording {

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

}  // namespace rubicon::recording
