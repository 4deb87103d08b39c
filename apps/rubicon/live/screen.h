#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "apps/rubicon/live/live_table.h"
#include "apps/rubicon/session.h"
#include "base/scheduler.h"

namespace rubicon::cli::live {

/// When a screen is drawn: soon after it was asked for and else from time to time, but never so often that drawing
/// takes more than its share of the loop's time, however fast keys come.
class DrawPace {
 public:
  static constexpr Duration kIdle = std::chrono::milliseconds(500);
  /// Drawing takes at most this fraction (1/n) of the loop's time.
  static constexpr int kShare = 10;

  /// `draw` returns how long it took.
  DrawPace(Scheduler& scheduler, std::function<Duration()> draw) : scheduler_(scheduler), draw_(std::move(draw)) {}

  /// Draws once, in a later turn, for all who ask until then.
  void ask();

 private:
  void draw();

  Scheduler& scheduler_;
  std::function<Duration()> draw_;
  SteadyTime earliest_{};
  bool asked_ = false;
  Timer due_;
};

/// Whether this process may draw on the terminal of its standard streams: they are one, and we are in its foreground.
bool owns_terminal();

struct ScreenOptions {
  std::optional<OwnerId> island;  ///< nullopt: all
  bool is_passive = false;        ///< wakes no sensors
  Duration length{};              ///< ends after this time; zero = never by itself
  /// Runs a command line that was typed, with the output of the session; may block.
  std::function<void(const std::string& line)> command;
};

/// Shows the live table on the terminal until a key or a signal ends it. Gives the terminal back as it was. The exit
/// code.
int show_table(Session& session, const ScreenOptions& options);

}  // namespace rubicon::cli::live
