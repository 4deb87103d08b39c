#pragma once

#include <functional>
#include <list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

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

/// Programs that watch the traffic of a line. Each asks with `{"do": "monitor", "id": ..., "seconds": ...}`, and gets
/// every message until its lease ends, at most ten minutes later. The same program and id renew the lease; 0 seconds
/// end it.
class Monitors {
 public:
  static constexpr std::size_t kMaxCount = 16;
  static constexpr Duration kMaxTime = std::chrono::minutes(10);
  static constexpr Duration kUsual = std::chrono::seconds(30);  ///< without `seconds`

  /// The host must outlive it.
  explicit Monitors(NetworkHost& host) : host_(host) {}

  /// kBusy if too many are open.
  Result<void> ask(const Address& program, const std::string& id, const nlohmann::json& request);
  bool any() const { return !all_.empty(); }
  /// To each of them, as an Opaque message with this tag.
  void send(std::string_view tag, std::string_view text);

 private:
  struct Monitor {
    Address program;
    std::string id;
    Timer lease;
  };
  NetworkHost& host_;
  std::list<Monitor> all_;
};

/// A text as an Opaque message to another component.
void send_text(NetworkHost& host, const Address& to, std::string_view tag, std::string_view text);

}  // namespace rubicon::network
