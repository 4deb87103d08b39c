#include "networks/zigbee/bridge/liveness.h"

#include <algorithm>

namespace rubicon::networks::zigbee::bridge {

Duration longest_reporting(const DeviceRecord& record) {
  constexpr std::uint32_t kNeverPeriodic = 0xffff;
  std::uint32_t longest = 0;
  for (const auto& reporting : record.reportings) {
    if (reporting.maximum_seconds < kNeverPeriodic) longest = std::max(longest, reporting.maximum_seconds);
  }
  return std::chrono::seconds(longest);
}

std::optional<Duration> silence_limit(const DeviceRecord& record) {
  if (record.is_group()) return std::nullopt;
  if (!record.mains()) return std::chrono::hours(25);
  return std::max<Duration>(3 * longest_reporting(record), std::chrono::hours(1));
}

bool bridge_decides(const BridgeDescription& bridge, const DeviceRecord& record) {
  return bridge.availability(record.address);
}

}  // namespace rubicon::networks::zigbee::bridge
