#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/live/rows.h"
#include "apps/rubicon/live/view.h"
#include "base/text.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::cli::live {

/// The last lines of the logs of islands, and the commands and answers of the screen itself.
class LiveLog {
 public:
  static constexpr std::size_t kKept = 1000;
  /// Of a line, in bytes.
  static constexpr std::size_t kMaxByteCount = 2000;

  struct Line {
    WallTime time{};
    bool is_complaint = false;  ///< a warning or an error
    std::string text;
  };

  void add(Line line);
  const std::deque<Line>& lines() const { return lines_; }
  /// Warnings and errors that were added.
  std::uint64_t complaints() const { return complaints_; }

 private:
  std::deque<Line> lines_;
  std::uint64_t complaints_ = 0;
};

struct ScreenSize {
  int rows = 24;
  int columns = 80;
};

using base::fitted;

/// One screen: a line for each of its rows. The only control characters are escape sequences for style. Also the column
/// of the cursor on the last line, from 1.
struct LiveFrame {
  std::vector<std::string> lines;
  std::size_t cursor_column = 1;
};

/// The table that `rubicon top` shows on a terminal: networks, devices and points with unit, quality and age, or the
/// log, or the help; below it a command to try, the last answer and the line that is typed. Draws nothing itself.
class LiveTable {
 public:
  /// `log` and what `source` reads must outlive it. `place`: where islands are looked for, for people.
  LiveTable(LiveSource source, const LiveLog& log, std::string place);

  /// Rates are counted there.
  LiveSource& source() { return source_; }

  /// A command line, if one was entered. Strokes act on what the last frame showed.
  std::optional<std::string> press(const Stroke& stroke);
  /// As many lines as the screen has rows, each as wide as it (columns: at least 20). `answer` may have several lines.
  LiveFrame frame(WallTime now, ScreenSize size, const std::string& answer);

 private:
  LiveView::Scene scene() const;
  std::string whose() const;
  std::string title(WallTime now, std::size_t width) const;
  std::string row_text(const LiveRow& row, WallTime now, std::size_t width) const;
  void put_body(std::vector<std::string>& lines, WallTime now, std::size_t room, std::size_t width);
  void put_table(std::vector<std::string>& lines, WallTime now, std::size_t width) const;
  void put_log(std::vector<std::string>& lines, std::size_t height, std::size_t width) const;
  static void put_help(std::vector<std::string>& lines, std::size_t height, std::size_t width);
  std::string prompt(std::size_t width, std::size_t& cursor) const;
  std::string counted_log() const;

  LiveSource source_;
  const LiveLog& log_;
  LiveView view_;
  std::string place_;
  std::vector<LiveIsland> islands_;  ///< of the last frame
  std::vector<LiveRow> rows_;        ///< in it
  std::string proposal_;             ///< in it
  std::size_t height_ = 1;           ///< of the table in it
};

}  // namespace rubicon::cli::live
