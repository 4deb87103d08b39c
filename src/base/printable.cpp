#include "base/printable.h"

#include <algorithm>

#include "base/utf8.h"

namespace rubicon::base {

namespace {

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
}

bool steers(char32_t code) {
  const auto in = [code](char32_t low, char32_t high) { return code >= low && code <= high; };
  const bool control = code < 0x20 || in(0x7f, 0x9f) || in(0x2028, 0x2029);
  return control || code == 0x061c || in(0x200e, 0x200f) || in(0x202a, 0x202e) || in(0x2066, 0x2069);
}

}  // namespace

std::size_t utf8_prefix(std::string_view text) {
  for (auto rest = text; !rest.empty();) {
    const auto at = text.size() - rest.size();
    if (!take_utf8(rest)) return at;
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
    auto rest = character;
    const auto code = take_utf8(rest);
    const bool good = code && rest.empty() && !steers(*code);
    good ? out += character : out += '?';
    text.remove_prefix(character.size());
  }
  return out.append(width - shown, ' ');
}

std::string printable(std::string_view text) {
  return fitted(text, characters(text));
}

}  // namespace rubicon::base
