#pragma once

#include <functional>

#include "base/virtual_scheduler.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/memory/memory_transports.h"

namespace rubicon::transport {

using namespace std::chrono_literals;

/// Where sockets are: the machine's own loopback, or memory.
struct World {
  virtual ~World() = default;
  virtual Transports& transports() = 0;
  /// Until it is so; false after a minute.
  virtual bool until(const std::function<bool()>& so) = 0;
};

struct MachineWorld final : World {
  Transports& transports() override { return local; }
  bool until(const std::function<bool()>& so) override {
    const auto end = loop.scheduler().now() + 60s;
    look(so, end);
    loop.run();
    return so();
  }
  void look(const std::function<bool()>& so, SteadyTime end) {
    if (so() || loop.scheduler().now() > end) return loop.stop();
    timer = loop.scheduler().after(1ms, [this, so, end] { look(so, end); });
  }

  Loop loop;
  LocalTransports local{loop};
  Timer timer;
};

struct MemoryWorld final : World {
  MemoryWorld() { memory.join(net); }
  Transports& transports() override { return memory; }
  bool until(const std::function<bool()>& so) override {
    for (int i = 0; i < 1000 && !so(); ++i) time.run_for(10ms);
    return so();
  }

  VirtualScheduler time;
  MemoryNet net{time};
  MemoryTransports memory;
};

}  // namespace rubicon::transport
