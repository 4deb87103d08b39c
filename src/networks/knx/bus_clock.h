#pragma once

#include <cstdint>

#include "networks/knx/dpt/dpt.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// Which time the clocks on the bus show.
enum class ClockZone : std::uint8_t { kLocal, kUtc };

/// Whether a type is a time of day (10.001), a date (11.001) or both (19.001).
bool is_clock_type(dpt::DptId id);

/// A moment as a clock on the bus shows it. Local: by the time zone of this process (TZ, /etc/localtime), with daylight
/// saving time. 19.001 also says whether that is in force, and whether the clock is set from outside (KNX
/// 3/7/2, 19.001: SUTI, CLQ). kRefused before 2020: the clock of this host was never set, and one on the bus may be
/// right.
Result<wire::Payload> clock_payload(dpt::DptId id, ClockZone zone, WallTime now, bool synchronised);

/// A number that changes when the day or the offset from UTC changes: clocks on the bus are then set at once.
std::int64_t clock_era(ClockZone zone, WallTime now);

/// Whether the system keeps the clock of this host synchronised: adjtimex(2), or, where that is forbidden, the word of
/// systemd-timesyncd.
bool is_clock_synchronised();

}  // namespace rubicon::networks::knx
