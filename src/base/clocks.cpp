#include "base/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <optional>

namespace rubicon::base {

namespace {

struct Local {
  std::tm calendar{};
  std::chrono::microseconds fraction{};
};

std::optional<Local> local_of(WallTime time) {
  const std::time_t whole = std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
  auto fraction = time.time_since_epoch() % std::chrono::seconds(1);
  if (fraction < fraction.zero()) fraction += std::chrono::seconds(1);
  Local local{{}, fraction};
  ::tzset();  // localtime_r() need not read TZ (POSIX)
  if (!::localtime_r(&whole, &local.calendar)) return std::nullopt;
  return local;
}

std::string formatted(const char* form, const std::tm& calendar) {
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), form, &calendar)};
}

/// `form` of the seconds, milliseconds if wanted, and the zone.
std::string text_of(WallTime time, const char* form, bool fraction) {
  const auto local = local_of(time);
  if (!local) return fmt::format("{:.6f} s since 1970", to_seconds(time));
  auto text = formatted(form, local->calendar);
  if (fraction) text += fmt::format(".{:03}", local->fraction.count() / 1000);
  return text + formatted(" %Z", local->calendar);
}

}  // namespace

std::string local_text(WallTime time) {
  return text_of(time, "%Y-%m-%d %H:%M:%S", true);
}

std::string local_clock_text(WallTime time) {
  return text_of(time, "%H:%M:%S", true);
}

std::string local_seconds_text(WallTime time) {
  return text_of(time, "%H:%M:%S", false);
}

std::string age_text(WallTime then, WallTime now) {
  if (then == WallTime{}) return "-";
  const auto seconds = std::max(0.0, to_seconds(now) - to_seconds(then));
  if (seconds < 9.95) return fmt::format("{:.1f}s", seconds);
  if (seconds < 120) return fmt::format("{:.0f}s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f}min", seconds / 60);
  if (seconds < 172800) return fmt::format("{:.0f}h", seconds / 3600);
  return fmt::format("{:.0f}d", seconds / 86400);
}

std::string iso_text(WallTime time) {
  const auto local = local_of(time);
  if (!local) return fmt::format("{:.6f} s since 1970", to_seconds(time));
  const auto minutes = local->calendar.tm_gmtoff / 60;
  return fmt::format("{}.{:06}{}{:02}:{:02}", formatted("%Y-%m-%dT%H:%M:%S", local->calendar), local->fraction.count(),
                     minutes < 0 ? '-' : '+', std::abs(minutes) / 60, std::abs(minutes) % 60);
}

std::string utc_text(WallTime time, const char* format) {
  const std::time_t whole = std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
  std::tm calendar{};
  if (::gmtime_r(&whole, &calendar) == nullptr) return fmt::format("{} s since 1970", whole);
  return formatted(format, calendar);
}

}  // namespace rubicon::base
