#include "base/bytes.h"

#include <fmt/format.h>

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

}  // namespace rubicon::base
