#include "networks/knx/bus_clock.h"

#include <fmt/format.h>
#include <sys/timex.h>
#include <unistd.h>

#include <array>
#include <ctime>

#include "base/local_time.h"

namespace rubicon::networks::knx {

namespace {

constexpr WallTime kNeverSet{std::chrono::seconds(1'577'836'800)};  // 2020
constexpr dpt::DptId kTime{10, 1}, kDate{11, 1}, kDateTime{19, 1};

std::tm calendar(ClockZone zone, WallTime now) {
  const auto seconds =
      static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(now.time_since_epoch()).count());
  std::tm parts{};
  zone == ClockZone::kLocal ? localtime_r(&seconds, &parts) : gmtime_r(&seconds, &parts);
  return parts;
}

}  // namespace

bool is_clock_type(dpt::DptId id) {
  return id == kTime || id == kDate || id == kDateTime;
}

Result<wire::Payload> clock_payload(dpt::DptId id, ClockZone zone, WallTime now, bool synchronised) {
  if (now < kNeverSet)
    return fail(ErrorCode::kRefused, fmt::format("the clock of this host shows {}: it was never set",
                                                 base::utc_text(now, "%Y-%m-%d %H:%M")));
  constexpr std::array kDays{"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  const auto parts = calendar(zone, now);
  const auto date = fmt::format("{:04}-{:02}-{:02}", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
  const auto time = fmt::format("{:02}:{:02}:{:02}", parts.tm_hour, parts.tm_min, std::min(parts.tm_sec, 59));
  const auto& type = *dpt::find_dpt(id);
  if (id == kDate) return dpt::encode_text(type, date);
  if (id == kTime)
    return dpt::encode_text(type, fmt::format("{} {}", kDays.at(static_cast<std::size_t>(parts.tm_wday)), time));
  return dpt::encode_text(type, fmt::format(R"({{"dateTime":"{}T{}","summerTime":{},"externalSync":{}}})", date, time,
                                            parts.tm_isdst > 0, synchronised));
}

std::int64_t clock_era(ClockZone zone, WallTime now) {
  const auto parts = calendar(zone, now);
  return (std::int64_t{parts.tm_year} * 366 + parts.tm_yday) * 1'000'000 + parts.tm_gmtoff;
}

/// A service may be forbidden to ask the kernel; systemd-timesyncd leaves a file.
bool is_clock_synchronised() {
  timex state{};
  if (::adjtimex(&state) >= 0) return (state.status & STA_UNSYNC) == 0;
  return ::access("/run/systemd/timesync/synchronized", F_OK) == 0;
}

}  // namespace rubicon::networks::knx
