#include "apps/rubicon/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "base/local_time.h"

namespace rubicon::cli {

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
