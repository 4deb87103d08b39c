#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/alerts.h"
#include "model/type_catalogue.h"
#include "proxy/naming.h"
#include "proxy/proxy_config.h"
#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"

namespace rubicon::proxy {

/// Presents the devices of the island as tuples (D1.4, chapter 3): publishes readings, turns subscriptions into
/// sampling, carries out commands. Construct it before networks start. Everything it takes by reference must outlive
/// it; without a store nothing is remembered beyond its end.
class Proxy {
 public:
  Proxy(ProxyConfig config, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
        const TypeCatalogue& types, base::LogSink& log, state::StateStore* store = nullptr);
  ~Proxy();

  /// The lines that quote what was set go to this log, which must outlive the proxy.
  void log_commands_to(base::LogSink& log);
  /// Lists the devices that the state file remembers. Call before the lines open.
  void restore();
  /// Why new rules cannot be applied: names by which two points of a device would claim one key.
  std::vector<Objection> objections(const ProxyConfig& next) const;
  /// Names in the next rules for points that the devices of that network do not have, one line each.
  std::vector<std::string> lost_names(const std::string& network, const NetworkRules& next) const;
  /// Applies new rules at run time: networks added or removed, their names, silence and rate; limits and discovery.
  /// Prefix and island name stay.
  void reconfigure(ProxyConfig config);
  /// The network is recreated: its devices are as after a restart of the island.
  void restart(const std::string& network);

  struct InboxCounters {
    std::uint64_t pending = 0, ignored = 0;
    std::uint64_t refused = 0;    ///< devices without room in the inbox
    std::uint64_t discarded = 0;  ///< messages of pending and ignored devices
  };
  InboxCounters inbox_counters() const;
  /// How many devices each network lists, reachable or not.
  std::map<std::string, std::uint64_t> device_counts() const;
  /// What of the networks and devices needs a person.
  void add_alerts(model::AlertList& list) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::proxy
