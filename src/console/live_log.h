#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"

namespace rubicon::console {

/// A log that a screen can show: keeps the last lines, and passes all on to another sink, unless that one would write
/// into the screen.
class LiveLog final : public base::LogSink {
 public:
  static constexpr std::size_t kKept = 1000;
  /// Of a line, in bytes.
  static constexpr std::size_t kMostBytes = 2000;

  struct Line {
    WallTime time{};
    base::LogLevel level = base::LogLevel::kInfo;
    std::string text;
  };

  /// `level` as in RunOptions::log_level. `behind` and `clock` must outlive this.
  LiveLog(base::LogSink& behind, const std::string& level, const base::Scheduler& clock);

  void write(base::LogLevel level, std::string_view who, std::string_view text) override;
  /// A line of the screen itself: a command, an answer. Never passed on.
  void note(std::string text);

  /// From now on nothing is passed on: the screen is the terminal of the sink behind.
  void hold() { held_ = true; }
  /// The screen is gone: the warnings and errors held meanwhile are passed on, at most the last kKept.
  void release();

  const std::deque<Line>& lines() const { return lines_; }
  /// Warnings and errors since the start.
  std::uint64_t complaints() const { return complaints_; }

 private:
  struct Held {
    base::LogLevel level;
    std::string who, text;
  };
  void keep(Line line);

  base::LogSink& behind_;
  const base::Scheduler& clock_;
  base::LogLevel least_ = base::LogLevel::kInfo;
  bool off_ = false, held_ = false;
  std::deque<Line> lines_;
  std::deque<Held> owed_;
  std::uint64_t complaints_ = 0;
};

}  // namespace rubicon::console
