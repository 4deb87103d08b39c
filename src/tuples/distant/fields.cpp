#include "tuples/distant/fields.h"

#include <algorithm>
#include <array>

namespace rubicon::tuples::distant {

namespace {

constexpr std::int64_t kMaxDuration = std::chrono::nanoseconds(std::chrono::years(100)).count();

}  // namespace

void FieldWriter::long_number(std::uint64_t value) {
  std::array<std::uint8_t, 10> groups;
  std::size_t size = 0;
  for (; value >= 0x80; value >>= 7) groups[size++] = static_cast<std::uint8_t>(value | 0x80);
  groups[size++] = static_cast<std::uint8_t>(value);
  bytes(ByteView(groups).first(size));
}

void FieldWriter::signed_number(std::int64_t value) {
  number((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
}

void FieldWriter::text(std::string_view text) {
  number(text.size());
  bytes(base::as_bytes(text));
}

std::uint64_t FieldReader::long_number() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const auto part = byte();
    value |= static_cast<std::uint64_t>(part & 0x7f) << shift;
    if ((part & 0x80) == 0) return shift == 63 && part > 1 ? fail_read() : value;
  }
  return fail_read();
}

std::int64_t FieldReader::signed_number() {
  const auto value = number();
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

std::string_view FieldReader::text() {
  const auto size = number();
  if (size > bytes_.size() - at_) return fail_read(), std::string_view();
  const auto found = base::as_text(bytes_.subspan(at_, static_cast<std::size_t>(size)));
  at_ += static_cast<std::size_t>(size);
  return found;
}

ByteView FieldReader::rest() {
  const auto found = bytes_.subspan(at_);
  at_ = bytes_.size();
  return found;
}

Duration FieldReader::duration() {
  return Duration(std::clamp<std::int64_t>(signed_number(), 0, kMaxDuration));
}

OwnerId FieldReader::owner() {
  const auto id = number();
  if (id > 0xffffffff) fail_read();
  return OwnerId(static_cast<std::uint32_t>(id));
}

std::uint8_t FieldReader::fail_read() {
  ok_ = false;
  at_ = bytes_.size();
  return 0;
}

}  // namespace rubicon::tuples::distant
