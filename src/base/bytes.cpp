#include "base/bytes.h"

#include <fmt/format.h>

#include <cstdint>

namespace rubicon::base {

namespace {

constexpr char kHexDigits[] = "0123456789abcdef";

int hex_value(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return -1;
}

std::uint64_t big_endian(ByteView bytes) {
  std::uint64_t value = 0;
  for (const auto byte : bytes) value = value << 8 | byte;
  return value;
}

std::uint64_t little_endian(ByteView bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

}  // namespace

ByteView ByteReader::take(std::size_t count) {
  if (!ok_ || count > remaining()) {
    ok_ = false;
    return {};
  }
  const auto view = bytes_.subspan(position_, count);
  position_ += count;
  return view;
}

std::uint8_t ByteReader::u8() {
  return static_cast<std::uint8_t>(big_endian(take(1)));
}
std::uint16_t ByteReader::u16_be() {
  return static_cast<std::uint16_t>(big_endian(take(2)));
}
std::uint32_t ByteReader::u32_be() {
  return static_cast<std::uint32_t>(big_endian(take(4)));
}
std::uint64_t ByteReader::u64_be() {
  return big_endian(take(8));
}
std::uint16_t ByteReader::u16_le() {
  return static_cast<std::uint16_t>(little_endian(take(2)));
}
std::uint32_t ByteReader::u32_le() {
  return static_cast<std::uint32_t>(little_endian(take(4)));
}

ByteWriter& ByteWriter::u8(std::uint8_t value) {
  bytes_.push_back(value);
  return *this;
}
ByteWriter& ByteWriter::u16_be(std::uint16_t value) {
  return u8(static_cast<std::uint8_t>(value >> 8)).u8(static_cast<std::uint8_t>(value));
}
ByteWriter& ByteWriter::u32_be(std::uint32_t value) {
  return u16_be(static_cast<std::uint16_t>(value >> 16)).u16_be(static_cast<std::uint16_t>(value));
}
ByteWriter& ByteWriter::u64_be(std::uint64_t value) {
  return u32_be(static_cast<std::uint32_t>(value >> 32)).u32_be(static_cast<std::uint32_t>(value));
}
ByteWriter& ByteWriter::u16_le(std::uint16_t value) {
  return u8(static_cast<std::uint8_t>(value)).u8(static_cast<std::uint8_t>(value >> 8));
}
ByteWriter& ByteWriter::u32_le(std::uint32_t value) {
  return u16_le(static_cast<std::uint16_t>(value)).u16_le(static_cast<std::uint16_t>(value >> 16));
}
ByteWriter& ByteWriter::bytes(ByteView value) {
  bytes_.insert(bytes_.end(), value.begin(), value.end());
  return *this;
}

std::string to_hex(ByteView bytes) {
  std::string text;
  text.reserve(bytes.size() * 2);
  for (const auto byte : bytes) {
    text.push_back(kHexDigits[byte >> 4]);
    text.push_back(kHexDigits[byte & 15]);
  }
  return text;
}

Result<Bytes> from_hex(std::string_view text) {
  Bytes bytes;
  bytes.reserve(text.size() / 2);  // a key that is read by this leaves no copy behind
  int high = -1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ' ' && high < 0) continue;
    const int value = hex_value(text[i]);
    if (value < 0) return fail(ErrorCode::kInvalid, fmt::format("hex text: position {} is not a hex digit", i));
    if (high < 0) {
      high = value;
    } else {
      bytes.push_back(static_cast<std::uint8_t>(high << 4 | value));
      high = -1;
    }
  }
  if (high >= 0) return fail(ErrorCode::kInvalid, "hex text: odd number of digits");
  return bytes;
}

namespace {

constexpr std::string_view kBase64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t kBytes = 3, kCharacters = 4;  // of a group

/// 24 bits from up to three bytes, the first in front.
std::uint32_t group_of(std::string_view bytes) {
  std::uint32_t group = 0;
  for (std::size_t i = 0; i < kBytes; ++i)
    group = group << 8U | (i < bytes.size() ? static_cast<std::uint8_t>(bytes[i]) : 0U);
  return group;
}

/// Characters of the last group that carry bytes: 4, 3 or 2; 0 if the padding is wrong.
std::size_t length_without_padding(std::string_view text) {
  if (text.size() % kCharacters != 0) return 0;
  auto length = text.size();
  while (length > 0 && text.size() - length < 2 && text[length - 1] == '=') --length;
  return length;
}

}  // namespace

std::string to_base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + kBytes - 1) / kBytes * kCharacters);
  for (; !bytes.empty(); bytes.remove_prefix(std::min(kBytes, bytes.size()))) {
    const auto group = group_of(bytes);
    const auto used = std::min(kBytes, bytes.size()) + 1;
    for (std::size_t i = 0; i < kCharacters; ++i) text += i < used ? kBase64[group >> (18 - 6 * i) & 63U] : '=';
  }
  return text;
}

Result<std::string> from_base64(std::string_view text) {
  const auto length = length_without_padding(text);
  if (length == 0 && !text.empty())
    return fail(
        ErrorCode::kInvalid,
        fmt::format("base 64: {} characters; expected groups of four, the last one padded with =", text.size()));
  std::string bytes;
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (std::size_t i = 0; i < length; ++i) {
    const auto digit = kBase64.find(text[i]);
    if (digit == kBase64.npos)
      return fail(ErrorCode::kInvalid, fmt::format("base 64: character {} is not one of A-Z a-z 0-9 + /", i + 1));
    bits = bits << 6U | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xffU);
  }
  return bytes;
}

}  // namespace rubicon::base
