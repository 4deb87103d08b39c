#include "base/utf8.h"

namespace rubicon::base {

namespace {

/// Length of the sequence and the smallest character that needs it (RFC 3629).
struct Lead {
  std::size_t length = 0;
  char32_t bits = 0;
  char32_t smallest = 0;
};

Lead lead_of(unsigned char byte) {
  if (byte < 0x80) return {1, byte, 0};
  if ((byte & 0xe0) == 0xc0) return {2, byte & 0x1fU, 0x80};
  if ((byte & 0xf0) == 0xe0) return {3, byte & 0x0fU, 0x800};
  if ((byte & 0xf8) == 0xf0) return {4, byte & 0x07U, 0x10000};
  return {};
}

bool is_character(char32_t code) {
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code <= 0x10ffff && !surrogate;
}

std::optional<char32_t> character_at(std::string_view text, const Lead& lead) {
  if (lead.length == 0 || lead.length > text.size()) return std::nullopt;
  char32_t character = lead.bits;
  for (std::size_t i = 1; i < lead.length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xc0) != 0x80) return std::nullopt;
    character = character << 6 | (byte & 0x3fU);
  }
  if (character < lead.smallest || !is_character(character)) return std::nullopt;
  return character;
}

}  // namespace

std::optional<char32_t> take_utf8(std::string_view& text) {
  if (text.empty()) return std::nullopt;
  const auto lead = lead_of(static_cast<unsigned char>(text[0]));
  const auto character = character_at(text, lead);
  text.remove_prefix(character ? lead.length : 1);
  return character;
}

void append_utf8(char32_t character, std::string& out) {
  constexpr char32_t kReplacement = 0xfffd;
  if (!is_character(character)) character = kReplacement;
  const auto put_rest = [&](unsigned shift) { out += static_cast<char>(0x80 | (character >> shift & 0x3f)); };
  if (character < 0x80) {
    out += static_cast<char>(character);
    return;
  }
  if (character < 0x800) {
    out += static_cast<char>(0xc0 | character >> 6);
  } else if (character < 0x10000) {
    out += static_cast<char>(0xe0 | character >> 12);
    put_rest(6);
  } else {
    out += static_cast<char>(0xf0 | character >> 18);
    put_rest(12);
    put_rest(6);
  }
  put_rest(0);
}

}  // namespace rubicon::base
