#pragma once

#include <memory>

#include "base/log.h"
#include "base/rate_limit.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "proxy/device.h"
#include "tuples/tuple_space.h"

namespace rubicon::proxy {

/// Reads the clocks once a turn of the loop, however many messages the turn brings.
class TurnClock {
 public:
  explicit TurnClock(Scheduler& scheduler) : scheduler_(scheduler) {}

  const Moment& now() { return *fresh_ ? moment_ : refresh(); }
  /// At the entry of timers, where the turn's moment may be older than the timer's own time.
  const Moment& refresh();

 private:
  Scheduler& scheduler_;
  Moment moment_{};
  std::shared_ptr<bool> fresh_ = std::make_shared<bool>(false);
};

/// What every part of the proxy may use. Owned by the Proxy, outlives the parts.
struct Surroundings {
  const ProxyConfig& config;
  Scheduler& scheduler;
  TupleSpace& space;
  gateway::Gateway& gateway;
  const TypeCatalogue& types;
  Log log;
  TurnClock clock;
  base::RateLimit log_limit{};
  std::uint64_t last_request = 0;

  std::uint64_t next_request() { return ++last_request; }
  /// A warning at most once a minute and subject.
  void warn(const std::string& subject, std::string_view text) {
    if (log_limit.allow(subject, clock.now().steady)) log.warning(text);
  }
};

/// Posts a call at most once until it ran, and not at all once it is destroyed.
class NextTurn {
 public:
  NextTurn(Scheduler& scheduler, std::function<void()> call)
      : scheduler_(scheduler), call_(std::make_shared<std::function<void()>>(std::move(call))) {}

  void ask();

 private:
  Scheduler& scheduler_;
  std::shared_ptr<std::function<void()>> call_;
  std::shared_ptr<bool> asked_ = std::make_shared<bool>(false);
};

}  // namespace rubicon::proxy
