#pragma once

#include "apps/simulators/motes/sink_port.h"
#include "support/memory/memory_tcp.h"

namespace rubicon::motes_simulator {

/// Makes the line of a simulated sink reachable on an in-memory network.
SinkPort::Opener on_memory(transport::MemoryTcp& net, transport::Endpoint at);

}  // namespace rubicon::motes_simulator
