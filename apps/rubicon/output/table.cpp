#include "apps/rubicon/output/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "base/clocks.h"
#include "base/text.h"

namespace rubicon::cli {

namespace {

using base::characters;
using base::first_character;

constexpr std::size_t kGap = 2;
/// A shorter key is not recognisable.
constexpr std::size_t kMinKey = 14;
/// Longer words of a text are broken, too.
constexpr std::size_t kMinText = 16;
/// Characters that a value gets before keys and texts get more.
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
    case Column::Kind::kKey: return std::min(longest, kMinKey);
    case Column::Kind::kText:
    case Column::Kind::kValue: return std::min({longest, longest_word, std::max(kMinText, characters(column.head))});
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

namespace {

constexpr std::size_t kBetweenColumns = 2;

const char* paint_of(std::string_view word) {
  constexpr std::array<std::string_view, 13> kRed{"bad",     "device-offline", "network-down", "unreachable", "refused",
                                                  "failed",  "timed-out",      "expired",      "problem",     "down",
                                                  "deleted", "lost",           "no-such-owner"};
  constexpr std::array<std::string_view, 9> kYellow{"stale", "stored", "assumed",    "unknown", "superseded",
                                                    "note",  "queued", "connecting", "absent"};
  constexpr std::array<std::string_view, 2> kGreen{"confirmed", "applied"};
  const auto is = [word](const auto& words) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (is(kRed)) return "\x1b[31m";
  if (is(kYellow)) return "\x1b[33m";
  return is(kGreen) ? "\x1b[32m" : nullptr;
}

/// `unreachable` of `unreachable: silent for 60s`.
std::string first_word(const std::string& text) {
  return text.substr(0, text.find(':'));
}

}  // namespace

std::string painted(const std::string& word, const std::string& shown, bool colour) {
  const auto* paint = colour ? paint_of(word) : nullptr;
  return paint ? paint + shown + "\x1b[0m" : shown;
}

std::string bold(const std::string& text, bool colour) {
  return colour ? "\x1b[1m" + text + "\x1b[0m" : text;
}

void Table::row(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  for (auto& cell : cells) cell = printable(cell);
  rows_.push_back(std::move(cells));
}

Widths Table::widths(std::size_t width) const {
  std::vector<std::size_t> longest, words;
  for (const auto& column : columns_) {
    longest.push_back(characters(column.head));
    words.push_back(longest_word_in(column.head));
  }
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      longest[i] = std::max(longest[i], characters(row[i]));
      words[i] = std::max(words[i], longest_word_in(row[i]));
    }
  }
  return widths_of(columns_, longest, words, width);
}

void Table::add_row(const std::vector<std::string>& row, const Widths& widths, const Look& look, bool head,
                    std::string& out) const {
  std::vector<std::vector<std::string>> cells;
  std::size_t lines = 1;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto width = widths.of[i];
    cells.push_back(columns_[i].kind == Column::Kind::kKey ? std::vector{shortened(row[i], width)}
                                                           : wrapped(row[i], width));
    if (width > 0) lines = std::max(lines, cells[i].size());
  }
  for (std::size_t line = 0; line < lines; ++line) {
    std::size_t owed = 0;  // blanks are written when something follows them
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (widths.of[i] == 0) continue;
      const auto text = line < cells[i].size() ? cells[i][line] : std::string();
      if (!text.empty()) {
        out +=
            std::string(owed, ' ') + (head ? bold(text, look.colour) : painted(first_word(row[i]), text, look.colour));
        owed = 0;
      }
      owed += widths.of[i] - characters(text) + kBetweenColumns;
    }
    out += '\n';
  }
}

std::string Table::text(const Look& look) const {
  const auto fitting = widths(look.width);
  std::vector<std::string> heads;
  for (const auto& column : columns_) heads.push_back(column.head);
  std::string out;
  add_row(heads, fitting, look, true, out);
  for (const auto& row : rows_) add_row(row, fitting, look, false, out);
  if (fitting.left_out.empty()) return out;
  const auto note =
      fmt::format("… {} left out: a wider terminal, a pipe or --json shows all", fmt::join(fitting.left_out, ", "));
  for (const auto& line : wrapped(note, look.width)) out += line + "\n";
  return out;
}

std::string time_text(WallTime time) {
  return time == WallTime{} ? "-" : base::local_text(time);
}

std::string clock_text(WallTime time) {
  return base::local_clock_text(time);
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace rubicon::cli
