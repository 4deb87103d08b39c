#pragma once

#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "runtime/island_config.h"
#include "runtime/recorder.h"
#include "transport/transports.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/tuple_space.h"

namespace rubicon::runtime {

/// A whole island: its component of the tuple space, gateway, proxy and networks, wired so that every listener is
/// attached before a line opens. Several may live in one process, on one ecology. Everything taken by reference must
/// outlive it.
class Island {
 public:
  /// Makes the networks (their own options are checked here, into `errors`) but opens nothing. kDuplicate if the
  /// island's id is present in the ecology, kInvalid if the errors are not empty.
  static Result<std::unique_ptr<Island>> make(IslandConfig config, Scheduler& scheduler,
                                              transport::Transports& transports, base::LogSink& log,
                                              tuples::MemoryEcology& ecology, base::ConfigErrors& errors);
  ~Island();

  /// Starts the recorders, opens the lines.
  void start();

  TupleSpace& space();
  gateway::Gateway& gateway();
  network::Supervisor& networks();
  const std::vector<std::unique_ptr<Recorder>>& recorders() const;
  const IslandConfig& config() const;

 private:
  struct Parts;
  explicit Island(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubicon::runtime
