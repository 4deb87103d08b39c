#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "apps/simulators/motes/world.h"
#include "base/virtual_scheduler.h"
#include "island/island.h"
#include "motes/measurements.h"
#include "transport/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bench::motes {

inline constexpr std::uint16_t kIsland = 42;
inline constexpr OwnerId kIslandOwner{kIsland};
inline constexpr std::uint16_t kFirstPort = 19202;

/// Throws if a call failed that the measurement needs.
void must(const Result<void>& result);
template <class T>
T must(Result<T> result) {
  must(result ? Result<void>() : Result<void>(fail(result.error())));
  return std::move(*result);
}

/// A configuration with a network `wsn-N` for each of these ports, each with these additional options.
std::string island_of(const std::vector<std::uint16_t>& ports, const std::string& options);
/// kFirstPort and the following ones.
std::vector<std::uint16_t> ports_of(int sinks);

/// A running island. Its parts must outlive it.
std::unique_ptr<island::Island> start_island(const std::string& yaml, Scheduler& scheduler,
                                             transport::Transports& transports, tuples::Ecology& ecology,
                                             std::unique_ptr<state::StateStore> state = nullptr);

/// The proxy lists the mote at that sink as reachable.
bool reachable(island::Island& island, std::uint16_t sink, std::uint16_t mote);

/// A component other than an island.
class Component {
 public:
  Component(tuples::Ecology& ecology, Scheduler& scheduler, std::uint32_t id);
  TupleSpace& operator*() { return *space_; }
  TupleSpace* operator->() { return space_.get(); }

 private:
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
};

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
