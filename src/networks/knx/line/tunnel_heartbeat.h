#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "base/deadline.h"
#include "networks/knx/line/tunnel_counters.h"

namespace rubicon::networks::knx::line {

/// Asks the server each minute whether it still knows the channel (knx.md, section 5.4). Part of Tunnel.
class TunnelHeartbeat {
 public:
  struct Callbacks {
    std::function<void()> request;                    ///< sends a CONNECTIONSTATE_REQUEST
    std::function<void(std::string why)> unanswered;  ///< no attempt succeeded
  };

  TunnelHeartbeat(Scheduler& scheduler, TunnelCounters& counters, Callbacks callbacks);

  void start();
  void stop() { deadline_.clear(); }
  /// A heartbeat was sent and its answer is due.
  bool awaits_answer() const { return state_ == State::kAwaitsAnswer; }
  /// The server knows the channel, asked by a heartbeat or otherwise.
  void succeeded();
  /// The server answered with another error than that it does not know the channel.
  void failed(std::uint8_t status);

 private:
  enum class State : std::uint8_t { kWaits, kAwaitsAnswer };

  void reached();
  void request();

  TunnelCounters& counters_;
  Callbacks callbacks_;
  State state_ = State::kWaits;
  unsigned attempts_ = 0;
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::knx::line
