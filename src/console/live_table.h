#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/printable.h"
#include "console/live_log.h"
#include "console/live_source.h"
#include "console/live_view.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::console {

struct ScreenSize {
  int rows = 24;
  int columns = 80;
};

using base::fitted;

/// One screen: a line for each of its rows, with escape sequences for style and nothing else that steers; and where the
/// cursor stands on the last line, from 1.
struct LiveFrame {
  std::vector<std::string> lines;
  std::size_t cursor_column = 1;
};

/// The table that `run` shows on a terminal: networks, devices and points with unit, quality and age, or the log, or
/// the help; below it a command to try, the last answer and the line that is typed. Draws nothing itself.
class LiveTable {
 public:
  /// `space` and `log` must outlive it.
  LiveTable(const TupleSpace& space, OwnerId island, std::string name, std::string prefix, const LiveLog& log);

  /// A command line, if one was entered. Strokes act on what the last frame showed.
  std::optional<std::string> press(const Stroke& stroke);
  /// As many lines as the screen has rows, each as wide as it (columns: at least 20).
  LiveFrame frame(WallTime now, ScreenSize size, const std::string& answer);

 private:
  LiveView::Scene scene() const;
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
  OwnerId island_;
  std::string name_;
  std::vector<LiveNetwork> networks_;
  std::vector<LiveRow> rows_;  ///< of the last frame
  std::string proposal_;       ///< in it
  std::size_t height_ = 1;     ///< of the table in it
};

}  // namespace rubicon::console
