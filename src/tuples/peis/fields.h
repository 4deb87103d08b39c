#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples::peis {

// Fields at their offsets, for the readers and writers of this folder. The caller has checked the size.

inline std::uint16_t u16_at(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}
inline std::uint32_t u32_at(ByteView bytes, std::size_t at) {
  return std::uint32_t{u16_at(bytes, at)} << 16 | u16_at(bytes, at + 2);
}
inline std::uint64_t u64_at(ByteView bytes, std::size_t at) {
  return std::uint64_t{u32_at(bytes, at)} << 32 | u32_at(bytes, at + 4);
}
inline std::uint32_t u32_le_at(ByteView bytes, std::size_t at) {
  return std::uint32_t{bytes[at + 3]} << 24 | std::uint32_t{bytes[at + 2]} << 16 | std::uint32_t{bytes[at + 1]} << 8 |
         bytes[at];
}

inline void put_u16(std::span<std::uint8_t> out, std::size_t at, std::uint16_t value) {
  out[at] = static_cast<std::uint8_t>(value >> 8);
  out[at + 1] = static_cast<std::uint8_t>(value & 0xff);
}
inline void put_u32(std::span<std::uint8_t> out, std::size_t at, std::uint32_t value) {
  put_u16(out, at, static_cast<std::uint16_t>(value >> 16));
  put_u16(out, at + 2, static_cast<std::uint16_t>(value & 0xffff));
}
inline void put_u64(std::span<std::uint8_t> out, std::size_t at, std::uint64_t value) {
  put_u32(out, at, static_cast<std::uint32_t>(value >> 32));
  put_u32(out, at + 4, static_cast<std::uint32_t>(value & 0xffffffff));
}
inline void put_u32_le(std::span<std::uint8_t> out, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) out[at + i] = static_cast<std::uint8_t>(value >> (8 * i) & 0xff);
}
inline void put_id(std::span<std::uint8_t> out, std::size_t at, OwnerId id) {
  put_u32(out, at, number(id));
}
inline void put_bytes(std::span<std::uint8_t> out, std::size_t at, ByteView bytes) {
  std::copy(bytes.begin(), bytes.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
}

/// An error of a body: `ROUTING: entries at 4: 71, expected at most 70`.
inline auto wrong_field(std::string_view body, std::string_view what) {
  return fail(ErrorCode::kInvalid, fmt::format("{}: {}", body, what));
}

inline Result<void> expect_size(std::string_view body, ByteView bytes, std::size_t size) {
  if (bytes.size() == size) return {};
  return wrong_field(body, fmt::format("{} bytes, expected {}", bytes.size(), size));
}

/// The text in a field of `size` bytes, which must end with a NUL.
inline Result<std::string_view> text_at(std::string_view body, std::string_view field, ByteView bytes, std::size_t at,
                                        std::size_t size) {
  const auto text = base::as_text(bytes.subspan(at, size));
  const auto end = text.find('\0');
  if (end != text.npos) return text.substr(0, end);
  return wrong_field(body, fmt::format("{} at {}: {} bytes without NUL, expected one", field, at, size));
}

}  // namespace rubicon::tuples::peis
