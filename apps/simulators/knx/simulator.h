#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "apps/simulators/knx/bus.h"
#include "apps/simulators/knx/script.h"
#include "apps/simulators/knx/server.h"
#include "apps/simulators/script.h"
#include "base/log.h"
#include "networks/knx/line/routing_line.h"

namespace rubicon::knx_simulator {

struct SimulatorOptions {
  ServerOptions server;
  bool tunnelling = true;
  std::optional<networks::knx::line::RoutingOptions> routing{};
  Server::Weather weather{};
  std::uint64_t seed = 1;
};

/// A KNX line with its devices, a tunnelling server and a router before it, and a script that moves them. Scheduler,
/// transports and the sink of the log must outlive it.
class Simulator {
 public:
  Simulator(SimulatorOptions options, Script script, Scheduler& scheduler, transport::Transports& transports, Log log);
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  /// Opens its ports and begins its script. kBusy if a port is taken.
  Result<void> open();

  const Bus& bus() const { return bus_; }
  const Server& server() const { return server_; }

 private:
  void take(const Step& step);
  void attach_server();
  Result<void> open_router();
  void reopen_router();
  void stop_server(Duration span);
  void restart_server();

  SimulatorOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  Bus bus_;
  Server server_;
  std::unique_ptr<networks::knx::line::RoutingLine> router_;
  simulation::ScriptRun<Step> script_;
  Timer restart_server_, reopen_router_;
};

/// The program knx-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::knx_simulator
