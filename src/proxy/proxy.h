#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "proxy/proxy_config.h"
#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"

namespace rubicon::proxy {

/// The island's face in the tuple space: device directory, tuple mirror, demand, command desk (D1.4, chapter 3). A
/// listener of the gateway; attach it before networks start. Everything it takes by reference must outlive it; without
/// a store it forgets everything at its end.
class Proxy {
 public:
  Proxy(ProxyConfig config, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
        const TypeCatalogue& types, base::LogSink& log, state::StateStore* store = nullptr);
  ~Proxy();

  /// Shows the devices that the state file remembers; call before the lines open.
  void restore();
  /// Why new rules cannot be taken, one line each: names by which two points of a device would claim one key.
  std::vector<std::string> objections(const ProxyConfig& next) const;
  /// Names that next rules give to points which the devices of that network do not have, one line each.
  std::vector<std::string> lost_names(const std::string& network, const NetworkRules& next) const;
  /// Takes new rules while everything runs: networks that went, came, or have other names, silence or rate; limits and
  /// discovery. Prefix and island name stay.
  void reconfigure(ProxyConfig config);
  /// The network is being made anew: its devices are as after a restart of the island.
  void restart(const std::string& network);

  struct InboxCounters {
    std::uint64_t pending = 0, ignored = 0;
    std::uint64_t refused = 0;    ///< devices there was no room for
    std::uint64_t discarded = 0;  ///< messages of pending and ignored devices
  };
  InboxCounters inbox_counters() const;
  /// How many devices each network lists, reachable or not.
  std::map<std::string, std::uint64_t> device_counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::proxy
