#include "base/printable.h"

#include <algorithm>

namespace rubicon::base {

namespace {

/// Length of the UTF-8 sequence that begins with this byte (RFC 3629), 0 = none does.
std::size_t sequence_length(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return 2;
  if (first >= 0xe0 && first <= 0xef) return 3;
  if (first >= 0xf0 && first <= 0xf4) return 4;
  return 0;
}

bool second_fits(unsigned char first, unsigned char second) {
  switch (first) {
    case 0xe0: return second >= 0xa0 && second <= 0xbf;
    case 0xed: return second >= 0x80 && second <= 0x9f;
    case 0xf0: return second >= 0x90 && second <= 0xbf;
    case 0xf4: return second >= 0x80 && second <= 0x8f;
    default: return second >= 0x80 && second <= 0xbf;
  }
}

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
}

/// Of a character that is well-formed.
char32_t code_of(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  char32_t code = first & (0x7fU >> character.size());
  for (const char c : character.substr(1)) code = code << 6U | (static_cast<unsigned char>(c) & 0x3fU);
  return code;
}

bool steers(char32_t code) {
  const auto in = [code](char32_t low, char32_t high) { return code >= low && code <= high; };
  const bool control = code < 0x20 || in(0x7f, 0x9f) || in(0x2028, 0x2029);
  return control || code == 0x061c || in(0x200e, 0x200f) || in(0x202a, 0x202e) || in(0x2066, 0x2069);
}

}  // namespace

std::size_t utf8_prefix(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const auto length = sequence_length(first);
    if (length == 0 || length > text.size() - i) return i;
    if (length > 1 && !second_fits(first, static_cast<unsigned char>(text[i + 1]))) return i;
    const auto rest = text.substr(i, length).substr(1);
    if (!std::all_of(rest.begin(), rest.end(), continues)) return i;
    i += length;
  }
  return text.size();
}

bool is_utf8(std::string_view text) {
  return utf8_prefix(text) == text.size();
}

std::size_t characters(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) text.remove_prefix(first_character(text).size());
  return count;
}

std::string one_line(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return printable(line);
}

std::string_view first_character(std::string_view text) {
  std::size_t length = std::min<std::size_t>(text.size(), 1);
  while (length < text.size() && continues(text[length])) ++length;
  return text.substr(0, length);
}

std::string fitted(std::string_view text, std::size_t width) {
  std::string out;
  std::size_t shown = 0;
  for (; !text.empty() && shown < width; ++shown) {
    const auto character = first_character(text);
    const bool good = is_utf8(character) && !steers(code_of(character));
    good ? out += character : out += '?';
    text.remove_prefix(character.size());
  }
  return out.append(width - shown, ' ');
}

std::string printable(std::string_view text) {
  return fitted(text, characters(text));
}

}  // namespace rubicon::base
