#include "console/strokes.h"

#include <array>
#include <optional>
#include <utility>

#include "base/printable.h"
#include "tuples/tuple_json.h"

namespace rubicon::console {

namespace {

using Key = Stroke::Key;

constexpr char kEscape = '\x1b';

std::optional<Key> control_key(char c) {
  switch (c) {
    case '\r':
    case '\n': return Key::kEnter;
    case '\t': return Key::kTab;
    case '\b':
    case '\x7f': return Key::kBackspace;
    case '\x0c': return Key::kRedraw;
    case '\x0e': return Key::kLater;
    case '\x10': return Key::kEarlier;
    case '\x15': return Key::kEraseLine;
    case '\x17': return Key::kEraseWord;
    default: return std::nullopt;
  }
}

/// Of `ESC [ 5 ~` the number, of `ESC [ A` and `ESC O A` the letter.
std::optional<Key> sequence_key(std::string_view sequence) {
  constexpr std::array<std::pair<char, Key>, 4> kLetters{
      {{'A', Key::kUp}, {'B', Key::kDown}, {'H', Key::kHome}, {'F', Key::kEnd}}};
  constexpr std::array<std::pair<std::string_view, Key>, 6> kNumbers{{{"1", Key::kHome},
                                                                      {"7", Key::kHome},
                                                                      {"4", Key::kEnd},
                                                                      {"8", Key::kEnd},
                                                                      {"5", Key::kPageUp},
                                                                      {"6", Key::kPageDown}}};
  const auto last = sequence.back();
  for (const auto& [letter, key] : kLetters) {
    if (letter == last) return key;
  }
  if (last != '~') return std::nullopt;
  const auto number = sequence.substr(2, sequence.find_first_of(";~", 2) - 2);
  for (const auto& [digits, key] : kNumbers) {
    if (digits == number) return key;
  }
  return std::nullopt;
}

/// Bytes of the sequence that begins here (ECMA-48, 5.4); 0 = its end has not come yet.
std::size_t sequence_length(std::string_view bytes) {
  if (bytes.size() < 2) return 0;
  if (bytes[1] == 'O') return bytes.size() < 3 ? 0 : 3;
  if (bytes[1] != '[') return 1;  // an escape, then another key
  for (std::size_t i = 2; i < bytes.size(); ++i) {
    if (bytes[i] >= 0x40 && bytes[i] <= 0x7e) return i + 1;
    if (bytes[i] < 0x20 || bytes[i] > 0x3f) return i;  // broken off
  }
  return 0;
}

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
}

/// Bytes of the UTF-8 character that begins here, 1 for what begins none; 0 = its end has not come yet.
std::size_t character_length(std::string_view bytes) {
  const auto first = static_cast<unsigned char>(bytes.front());
  if (first < 0xc2 || first > 0xf4) return 1;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i) {
    if (i == bytes.size()) return 0;
    if (!continues(bytes[i])) return 1;  // broken off
  }
  return length;
}

/// Takes one stroke or what is none from the front; false: more bytes are needed.
bool take_one(std::string_view& bytes, std::vector<Stroke>& strokes) {
  std::size_t length = 1;
  if (bytes.front() == kEscape) {
    length = sequence_length(bytes);
    if (length == 0) return false;
    const auto key = length == 1 ? std::optional(Key::kEscape) : sequence_key(bytes.substr(0, length));
    if (key) strokes.push_back({*key});
  } else if (const auto key = control_key(bytes.front())) {
    strokes.push_back({*key});
  } else if (static_cast<unsigned char>(bytes.front()) >= 0x20) {
    length = character_length(bytes);
    if (length == 0) return false;
    const auto character = bytes.substr(0, length);
    if (base::is_utf8(character)) {
      strokes.push_back({Key::kText, std::string(character)});
    } else {
      length = 1;
    }
  }
  bytes.remove_prefix(length);
  return true;
}

}  // namespace

std::vector<Stroke> StrokeReader::take(std::string_view bytes) {
  const auto all = std::exchange(held_, {}) + std::string(bytes);
  std::vector<Stroke> strokes;
  auto rest = std::string_view(all);
  while (!rest.empty() && take_one(rest, strokes)) continue;
  if (rest.size() < kLongest) held_ = rest;
  return strokes;
}

std::vector<Stroke> StrokeReader::settle() {
  const bool escape = std::exchange(held_, {}) == std::string(1, kEscape);
  return escape ? std::vector<Stroke>{{Key::kEscape}} : std::vector<Stroke>{};
}

}  // namespace rubicon::console
