#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/lifetime.h"
#include "base/limited_log.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "proxy/device.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::proxy {

/// Reads the clocks once per turn of the loop, however many messages the turn brings.
class TurnClock {
 public:
  explicit TurnClock(Scheduler& scheduler)
      : scheduler_(scheduler), end_of_turn_(scheduler, [this] { fresh_ = false; }) {}
  TurnClock(const TurnClock&) = delete;
  TurnClock& operator=(const TurnClock&) = delete;

  const Moment& now() { return fresh_ ? moment_ : refresh(); }
  /// Timers call this first: the moment of the turn may be older than the time the timer was set for.
  const Moment& refresh();

 private:
  Scheduler& scheduler_;
  Moment moment_{};
  bool fresh_ = false;
  base::OncePerTurn end_of_turn_;
};

/// What every part of the proxy may use. Owned by the Proxy, outlives the parts.
struct ProxyContext {
  const ProxyConfig& config;
  Scheduler& scheduler;
  TupleSpace& space;
  gateway::Gateway& gateway;
  const TypeCatalogue& types;
  Log log;
  Log commands = log;  ///< gets the lines that quote what was set
  TurnClock clock{scheduler};
  base::LimitedLog limited_log{log, scheduler};
  std::uint64_t last_request = 0;

  std::uint64_t next_request() { return ++last_request; }
  /// One warning per subject and minute; the others are discarded.
  void warn(const std::string& subject, std::string_view text) { limited_log.warning(subject, text); }
};

}  // namespace rubicon::proxy
