#include "apps/rubicon/layout.h"

#include <algorithm>

#include "base/printable.h"

namespace rubicon::cli {

namespace {

using base::characters;
using base::first_character;

constexpr std::size_t kGap = 2;
/// A shorter key is not recognisable.
constexpr std::size_t kShortestKey = 14;
/// Longer words of a text are broken, too.
constexpr std::size_t kShortestText = 16;
/// What a value gets before keys and texts get more.
constexpr std::size_t kRoomOfValues = 30;

/// The first `count` characters.
std::string_view head_of(std::string_view text, std::size_t count) {
  std::size_t bytes = 0;
  for (; count > 0 && bytes < text.size(); --count) bytes += first_character(text.substr(bytes)).size();
  return text.substr(0, bytes);
}

/// Up to the last blank, or with the last `|`; all of a line that has neither.
std::string_view up_to_a_break(std::string_view line) {
  const auto at = line.find_last_of(" |");
  if (at == line.npos || at == 0) return line;
  return line.substr(0, line[at] == '|' ? at + 1 : at);
}

std::size_t shortest(const Column& column, std::size_t longest, std::size_t longest_word) {
  switch (column.kind) {
    case Column::Kind::kWord: return longest;
    case Column::Kind::kKey: return std::min(longest, kShortestKey);
    case Column::Kind::kText:
    case Column::Kind::kValue:
      return std::min({longest, longest_word, std::max(kShortestText, characters(column.head))});
  }
  return longest;
}

std::size_t line_of(const std::vector<std::size_t>& widths) {
  std::size_t sum = 0;
  for (const auto one : widths) sum += one > 0 ? one + kGap : 0;
  return sum > 0 ? sum - kGap : 0;
}

/// The narrowest column that could use one more character.
std::size_t neediest(const std::vector<std::size_t>& now, const std::vector<std::size_t>& wanted) {
  std::size_t found = now.size();
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i] > 0 && now[i] < wanted[i] && (found == now.size() || now[i] < now[found])) found = i;
  }
  return found;
}

void grow(std::vector<std::size_t>& now, const std::vector<std::size_t>& wanted, std::size_t width) {
  for (auto room = width - std::min(width, line_of(now)); room > 0; --room) {
    const auto one = neediest(now, wanted);
    if (one == now.size()) return;
    ++now[one];
  }
}

}  // namespace

Widths widths_of(const std::vector<Column>& columns, const std::vector<std::size_t>& longest,
                 const std::vector<std::size_t>& longest_word, std::size_t width) {
  if (width == 0 || line_of(longest) <= width) return {longest, {}};
  Widths widths;
  for (std::size_t i = 0; i < columns.size(); ++i)
    widths.of.push_back(shortest(columns[i], longest[i], longest_word[i]));
  while (line_of(widths.of) > width) {
    std::size_t last = columns.size();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool there = widths.of[i] > 0 && columns[i].rank > 0;
      if (there && (last == columns.size() || columns[i].rank > columns[last].rank)) last = i;
    }
    if (last == columns.size()) break;
    widths.of[last] = 0;
    widths.left_out.push_back(columns[last].head);
  }
  auto wanted = widths.of;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].kind == Column::Kind::kValue) wanted[i] = std::max(wanted[i], std::min(longest[i], kRoomOfValues));
  }
  grow(widths.of, wanted, width);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].kind == Column::Kind::kKey) wanted[i] = longest[i];  // texts can be wrapped
  }
  grow(widths.of, wanted, width);
  grow(widths.of, longest, width);
  return widths;
}

std::string shortened(std::string_view text, std::size_t width) {
  const auto size = characters(text);
  if (size <= width) return std::string(text);
  if (width == 0) return {};
  const auto front = (width - 1) / 3;
  const auto back = width - 1 - front;
  return std::string(head_of(text, front)) + "…" + std::string(text.substr(head_of(text, size - back).size()));
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  while (width > 0 && characters(text) > width) {
    auto line = head_of(text, width);
    if (text[line.size()] != ' ') line = up_to_a_break(line);
    lines.emplace_back(line);
    text.remove_prefix(line.size());
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  }
  if (!text.empty() || lines.empty()) lines.emplace_back(text);
  return lines;
}

std::size_t longest_word_in(std::string_view text) {
  std::size_t longest = 0;
  while (!text.empty()) {
    const auto word = text.substr(0, text.find_first_of(" |"));
    longest = std::max(longest, characters(word));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return longest;
}

}  // namespace rubicon::cli
