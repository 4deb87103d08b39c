#pragma once

#include <functional>
#include <optional>

#include "network/network.h"

namespace rubicon::network {

/// Delivers the State of a network's line: at once when the line changed, and once for all changes of counters within
/// a period. Destroying it cancels a pending report.
class StateReporter {
 public:
  /// `state` returns what to deliver; nullopt while there is nothing to report, such as before the first open() and
  /// while the line is lost (the supervisor then reports).
  using State = std::function<std::optional<model::State>()>;

  StateReporter(NetworkHost& host, State state, Duration period = std::chrono::seconds(1))
      : host_(host), state_(std::move(state)), period_(period) {}

  /// The line changed: reports now. A pending report is cancelled, as this one has the same counters.
  void line_changed();
  /// A counter or text changed: reports within the period.
  void counters_changed();

 private:
  NetworkHost& host_;
  State state_;
  Duration period_;
  Timer pending_;
};

}  // namespace rubicon::network
