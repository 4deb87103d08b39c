#include "apps/rubicon/table.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "runtime/live_table.h"
#include "runtime/recording_text.h"

namespace rubicon::cli {

namespace {

constexpr std::size_t kGap = 2;

/// Seconds of a day, of UTC.
std::chrono::microseconds in_day(WallTime time) {
  return time - std::chrono::floor<std::chrono::days>(time);
}

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

}  // namespace

std::size_t characters(std::string_view text) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; };
  // A text may begin in the middle of a character: that is one more.
  const std::size_t torn = !text.empty() && !begins(text.front()) ? 1 : 0;
  return torn + static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins));
}

std::string clean(std::string_view text) {
  return runtime::fitted(text, characters(text));
}

std::string cut(const std::string& text, std::size_t width) {
  return width == 0 || characters(text) <= width ? text : runtime::fitted(text, width);
}

std::string painted(const std::string& word, const std::string& shown, bool colour) {
  const auto* paint = colour ? paint_of(word) : nullptr;
  return paint ? paint + shown + "\x1b[0m" : shown;
}

std::string bold(const std::string& text, bool colour) {
  return colour ? "\x1b[1m" + text + "\x1b[0m" : text;
}

void Table::row(std::vector<std::string> cells) {
  cells.resize(heads_.size());
  for (auto& cell : cells) cell = clean(cell);
  rows_.push_back(std::move(cells));
}

std::string Table::text(const Look& look) const {
  std::vector<std::size_t> widths;
  for (const auto& head : heads_) widths.push_back(characters(head));
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], characters(row[i]));
  }
  std::string out;
  const auto put = [&](const std::vector<std::string>& row, bool head) {
    std::size_t used = 0, owed = 0;  // blanks are written when something follows them
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto size = characters(row[i]);
      const auto room = look.width == 0 ? size : look.width - std::min(look.width, used + owed);
      if (size > 0 && room > 0) {
        const auto cut = room < size ? runtime::fitted(row[i], room) : row[i];
        out += std::string(owed, ' ') + (head ? bold(cut, look.colour) : painted(row[i], cut, look.colour));
        used += owed + std::min(size, room);
        owed = 0;
      }
      owed += widths[i] - std::min(size, widths[i]) + kGap;
    }
    out += '\n';
  };
  put(heads_, true);
  for (const auto& row : rows_) put(row, false);
  return out;
}

std::string age_text(WallTime then, WallTime now) {
  if (then == WallTime{}) return "-";
  const auto seconds = std::max(0.0, base::to_seconds(now) - base::to_seconds(then));
  if (seconds < 9.95) return fmt::format("{:.1f}s", seconds);
  if (seconds < 120) return fmt::format("{:.0f}s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f}min", seconds / 60);
  if (seconds < 172800) return fmt::format("{:.0f}h", seconds / 3600);
  return fmt::format("{:.0f}d", seconds / 86400);
}

std::string time_text(WallTime time) {
  return time == WallTime{} ? "-" : runtime::utc_text(time);
}

std::string clock_text(WallTime time) {
  return fmt::format("{:%H:%M:%S}", std::chrono::floor<std::chrono::milliseconds>(in_day(time)));
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace rubicon::cli
