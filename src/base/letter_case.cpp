#include "base/letter_case.h"

#include <cstdint>

namespace rubicon::base {

std::string to_lower(std::string_view utf8) {
  std::string out(utf8);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(out[i]);
    if (byte >= 'A' && byte <= 'Z') {
      out[i] = static_cast<char>(byte + 0x20);
    } else if (byte == 0xc3 && i + 1 < out.size()) {  // U+00C0..U+00DE, but not the sign of multiplication
      const auto next = static_cast<std::uint8_t>(out[++i]);
      if (next >= 0x80 && next <= 0x9e && next != 0x97) out[i] = static_cast<char>(next + 0x20);
    } else if ((byte == 0xc4 || byte == 0xc5) && i + 1 < out.size()) {  // U+0100..U+0137, U+014A..U+0177
      const auto next = static_cast<std::uint8_t>(out[++i]);
      const bool even_is_big = byte == 0xc4 ? next <= 0xb7 && next != 0xb0 : next >= 0x8a && next <= 0xb7;
      if (even_is_big && (next & 1) == 0) out[i] = static_cast<char>(next + 1);
    }
  }
  return out;
}

}  // namespace rubicon::base
