#pragma once

#include <memory>
#include <string_view>

#include "base/virtual_scheduler.h"
#include "island/island.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::island {

/// Island 6541 with simulated rooms, in virtual time, and a component beside it.
class VirtualIsland {
 public:
  /// `rooms` is the map under `simulate:`, `more` further networks.
  explicit VirtualIsland(std::string_view rooms, std::string_view more = "");

  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<island::Island> island;
  std::unique_ptr<tuples::Link> link;
  std::unique_ptr<TupleSpace> space;  ///< of component 65536
};

}  // namespace rubicon::island
