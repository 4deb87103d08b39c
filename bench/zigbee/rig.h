#pragma once

#include <memory>
#include <set>
#include <string>

#include "base/virtual_scheduler.h"
#include "frame/running_island.h"
#include "tuples/memory/memory_ecology.h"
#include "zigbee/direct_line.h"
#include "zigbee/measurements.h"
#include "zigbee/timed_scheduler.h"

namespace rubicon::bench::zigbee {

inline constexpr OwnerId kIsland{43};
inline constexpr std::uint16_t kPort = 1883;

/// bridge/info, as much of it as a network needs.
inline constexpr std::string_view kBridgeInfo =
    R"({"version":"2.14.1","config":{"advanced":{"last_seen":"ISO_8601"}}})";

/// The configuration of an island with the network `zigbee` at the broker on this host.
std::string island_yaml();

/// bench::start_island() of it.
std::unique_ptr<island::Island> start_island(Scheduler& scheduler, transport::Transports& transports,
                                             tuples::Ecology& ecology);

/// Keys of the status tuples of the devices that the island lists.
std::set<std::string> listed_devices(island::Island& island);
std::string line_of(island::Island& island);

/// An island at a line that costs nothing, in virtual time: an island's work takes none of it.
struct VirtualRig {
  VirtualRig();
  /// What a bridge publishes; then runs what is due.
  void say(std::string_view topic, std::string_view payload);
  /// Bridge and list of devices.
  void begin(const std::string& list);

  VirtualScheduler virtual_time;
  TimedScheduler time{virtual_time};
  DirectTransports transports{time};
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<island::Island> island;
};

}  // namespace rubicon::bench::zigbee
