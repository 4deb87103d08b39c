#pragma once

#include <optional>
#include <string>

#include "networks/log/replay_clock.h"
#include "transport/transports.h"

namespace rubicon::networks::log {

/// The time of the last record of a recording of our own, found from the end of the file; nullopt where it cannot be
/// read, or has no sound block near its end.
std::optional<RecordTime> end_of_recording(transport::Transports& transports, const std::string& path);

}  // namespace rubicon::networks::log
