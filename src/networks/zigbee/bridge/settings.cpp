#include "networks/zigbee/bridge/settings.h"

#include <algorithm>

namespace rubicon::networks::zigbee::bridge {

std::vector<Recommendation> recommendations(const BridgeDescription& bridge) {
  std::vector<Recommendation> found;
  if (bridge.output == "attribute") {
    found.push_back({"advanced.output", bridge.output, "json",
                     "The bridge publishes each property on a topic of its own; values of devices are not read."});
  }
  if (!bridge.retained) {
    found.push_back({"mqtt.force_disable_retain", "true", "false",
                     "The broker keeps no list of devices; they appear only after the next change in the bridge."});
  }
  if (!bridge.cache_state) {
    found.push_back({"advanced.cache_state", "false", "true",
                     "A state message has only a part of the values; more of them stay unknown after a restart."});
  }
  if (!bridge.last_seen_published()) {
    found.push_back({"advanced.last_seen", bridge.last_seen, "ISO_8601",
                     "Without it, new reports cannot be distinguished from repeated values, and commands are confirmed "
                     "later."});
  }
  if (!bridge.availability_enabled) {
    found.push_back(
        {"availability.enabled", "false", "true",
         "The bridge then reports within minutes which devices do not answer; without it this takes hours."});
  }
  if (!bridge.all.retain.value_or(false)) {
    found.push_back({"device_options.retain", "false", "true",
                     "Without it, the values of devices with batteries are unknown after a start of the island until "
                     "they report, which takes hours."});
  }
  if (bridge.log_level == "debug" || bridge.log_level == "info") {
    found.push_back({"advanced.log_level", bridge.log_level, "warning",
                     "The bridge publishes each line of its log; that doubles the load of the broker."});
  }
  return found;
}

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
