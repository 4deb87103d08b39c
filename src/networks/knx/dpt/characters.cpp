#include "networks/knx/dpt/characters.h"

namespace rubicon::networks::knx::dpt {

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

std::optional<char32_t> character_at(std::string_view text, const Lead& lead) {
  if (lead.length == 0 || lead.length > text.size()) return std::nullopt;
  char32_t character = lead.bits;
  for (std::size_t i = 1; i < lead.length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xc0) != 0x80) return std::nullopt;
    character = character << 6 | (byte & 0x3fU);
  }
  const bool surrogate = character >= 0xd800 && character < 0xe000;
  if (character < lead.smallest || character > 0x10ffff || surrogate) return std::nullopt;
  return character;
}

}  // namespace

std::optional<char32_t> take_character(std::string_view& text) {
  const auto lead = lead_of(static_cast<unsigned char>(text[0]));
  const auto character = character_at(text, lead);
  text.remove_prefix(character ? lead.length : 1);
  return character;
}

void append_character(char32_t character, std::string& out) {
  if (character < 0x80) {
    out += static_cast<char>(character);
    return;
  }
  if (character < 0x800) {
    out += static_cast<char>(0xc0 | character >> 6);
  } else {
    out += static_cast<char>(0xe0 | character >> 12);
    out += static_cast<char>(0x80 | (character >> 6 & 0x3f));
  }
  out += static_cast<char>(0x80 | (character & 0x3f));
}

}  // namespace rubicon::networks::knx::dpt
