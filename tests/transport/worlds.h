#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/virtual_scheduler.h"
#include "support/memory/memory_transports.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/poll_loop.h"

namespace rubicon::transport {

using namespace std::chrono_literals;

/// Where sockets are: the machine's own loopback, on either loop, or memory.
struct World {
  virtual ~World() = default;
  virtual Transports& transports() = 0;
  /// Until it is so; false after kMaxTime, in memory after ten seconds.
  virtual bool until(const std::function<bool()>& so) = 0;
};

/// What a real world may take: 256 MB through a broker need 5 s where nothing else runs.
constexpr Duration kMaxTime = 5min;

struct MachineWorld final : World {
  Transports& transports() override { return local; }
  bool until(const std::function<bool()>& so) override {
    const auto end = loop.scheduler().now() + kMaxTime;
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

/// The machine's own loopback in the loop of a client.
struct PollWorld final : World {
  Transports& transports() override { return *sockets; }
  bool until(const std::function<bool()>& so) override {
    for (const auto end = loop->now() + kMaxTime; !so() && loop->now() < end; loop->poll()) loop->wait(10ms);
    return so();
  }

  std::unique_ptr<PollLoop> loop = std::move(*PollLoop::make());
  std::unique_ptr<PollSockets> sockets = std::make_unique<PollSockets>(*loop);
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

enum class Where : std::uint8_t { kMemory, kMachine, kPollLoop };

inline std::unique_ptr<World> make_world(Where where) {
  if (where == Where::kMachine) return std::make_unique<MachineWorld>();
  if (where == Where::kPollLoop) return std::make_unique<PollWorld>();
  return std::make_unique<MemoryWorld>();
}
inline std::string name_of(Where where) {
  return where == Where::kMachine ? "TheMachine" : where == Where::kPollLoop ? "ThePollLoop" : "Memory";
}

}  // namespace rubicon::transport
