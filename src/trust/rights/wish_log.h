#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"

namespace rubicon::trust::rights {

/// Lines about wishes in a log: at most kLines in kWindow, then how many more there were.
class WishLog {
 public:
  static constexpr std::size_t kLines = 50;
  static constexpr Duration kWindow = std::chrono::seconds(10);

  /// `what`: `refused requests`. `where`: the file that has all of them; empty = there is none.
  WishLog(Scheduler& scheduler, Log log, std::string_view what, std::string where)
      : scheduler_(scheduler), log_(std::move(log)), what_(what), where_(std::move(where)) {}

  /// `text` is one line.
  void write(std::string_view text);

 private:
  Scheduler& scheduler_;
  Log log_;
  std::string what_, where_;
  SteadyTime window_ = SteadyTime::min();
  std::uint64_t logged_ = 0, more_ = 0;
  Timer end_;
};

}  // namespace rubicon::trust::rights
