#include "base/base64.h"

#include <fmt/format.h>

#include <cstdint>

namespace rubicon::base {

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
      return fail(ErrorCode::kInvalid, fmt::format("base 64: character {} is none of A-Z a-z 0-9 + /", i + 1));
    bits = bits << 6U | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xffU);
  }
  return bytes;
}

}  // namespace rubicon::base
