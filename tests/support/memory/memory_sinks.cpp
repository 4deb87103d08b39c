#include "support/memory/memory_sinks.h"

#include <utility>

namespace rubicon::motes_simulator {

SinkPort::Opener on_memory(transport::MemoryTcp& net, transport::Endpoint at) {
  return [&net, at = std::move(at)](SinkPort& port) -> Result<std::shared_ptr<void>> {
    return std::shared_ptr<transport::MemoryListener>(
        net.listen(at, [&port](auto stream) { return port.take(std::move(stream)); }));
  };
}

}  // namespace rubicon::motes_simulator
