#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"

namespace rubicon::island {

/// A log whose last lines an island can show to other components: keeps them in bounded memory, with secrets masked
/// (base/masked.h), and passes every line on unchanged.
class LogLines final : public base::LogSink {
 public:
  static constexpr std::size_t kKept = 100;
  /// Of a line, in bytes.
  static constexpr std::size_t kMostText = 2000, kMostSubject = 100;

  struct Line {
    std::uint64_t number = 0;  ///< counts from 1, so that readers find what they missed
    WallTime time{};
    base::LogLevel level = base::LogLevel::kInfo;
    std::string subject, text;  ///< one line of printable text each
  };

  /// Lines below `least` are passed on and not kept. `behind` and `clock` must outlive this.
  LogLines(base::LogSink& behind, const base::Scheduler& clock, base::LogLevel least = base::LogLevel::kInfo)
      : behind_(behind), clock_(clock), least_(least) {}

  void write(base::LogLevel level, std::string_view who, std::string_view text) override;

  /// Called after each line that is kept; it may only ask for a later turn. Empty = no call.
  void on_line(std::function<void()> call) { call_ = std::move(call); }
  const std::deque<Line>& lines() const { return lines_; }
  /// JSON list of {number, time, level, subject, text}, the oldest first.
  std::string json() const;

 private:
  base::LogSink& behind_;
  const base::Scheduler& clock_;
  base::LogLevel least_;
  std::uint64_t written_ = 0;
  std::deque<Line> lines_;
  std::function<void()> call_;
};

}  // namespace rubicon::island
