#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "base/scheduler.h"

namespace rubicon::trust::rights {

/// Says which refusals of a name, that of the member who delivered the wish, get a line of their own, and counts the
/// rest. Bounded: beyond kMostNames at a time all further names share one count.
class RefusalLimit {
 public:
  static constexpr std::size_t kMostNames = 256;
  static constexpr std::uint64_t kPerSecond = 100;
  /// Of a flood that goes on for a day the files hold less than half: it does not push out what was accepted.
  static constexpr std::uint64_t kPerHour = 5'000, kAllPerHour = 10'000;
  static constexpr Duration kSecond = std::chrono::seconds(1);
  static constexpr Duration kHour = std::chrono::hours(1);
  /// How often the count of a name is written that used up its hour.
  static constexpr Duration kPause = std::chrono::minutes(1);
  static constexpr const char* kOthers = "others";

  /// `more`: so many refusals of that name got no line since the last call for it.
  RefusalLimit(Scheduler& scheduler, std::function<void(std::string_view who, std::uint64_t count)> more)
      : scheduler_(scheduler), more_(std::move(more)) {}

  /// False: it was counted.
  bool allow(std::string_view who);
  /// Reports all counts now.
  void flush();

 private:
  struct Name {
    SteadyTime second{}, hour{}, report{};  ///< begin of the second and the hour; when the count is written
    std::uint64_t in_second = 0, in_hour = 0, more = 0;
  };
  Name& name(std::string_view who, SteadyTime now);
  void report(SteadyTime now);
  void plan();

  Scheduler& scheduler_;
  std::function<void(std::string_view, std::uint64_t)> more_;
  std::map<std::string, Name, std::less<>> names_;
  SteadyTime hour_{};          ///< begin of the hour of all names
  std::uint64_t in_hour_ = 0;  ///< of all names
  Timer timer_;
};

}  // namespace rubicon::trust::rights
