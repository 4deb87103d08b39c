#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "apps/simulators/motes/world.h"
#include "base/virtual_scheduler.h"
#include "frame/running_island.h"
#include "motes/measurements.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bench::motes {

inline constexpr std::uint16_t kIsland = 42;
inline constexpr OwnerId kIslandOwner{kIsland};
inline constexpr std::uint16_t kFirstPort = 19202;

/// A configuration with a network `wsn-N` for each of these ports, each with these additional options.
std::string island_of(const std::vector<std::uint16_t>& ports, const std::string& options);
/// kFirstPort and the following ones.
std::vector<std::uint16_t> ports_of(int sinks);

/// The proxy lists the mote at that sink as reachable.
bool reachable(island::Island& island, std::uint16_t sink, std::uint16_t mote);

/// Sinks, motes and what an island needs, in virtual time: an island's work takes none of it.
struct VirtualRig {
  /// `motes` at each sink, with addresses from 2.
  VirtualRig(int sinks, int motes, motes_simulator::MoteOptions like = {},
             motes_simulator::EventLog::Callback events = {});

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports transports;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<motes_simulator::World> world;
};
/// Sinks and motes (EM1000) of such a world; the motes boot when a computer connects.
motes_simulator::WorldOptions world_of(int sinks, int motes, const motes_simulator::MoteOptions& like = {});

}  // namespace rubicon::bench::motes
