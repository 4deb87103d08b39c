#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "base/scheduler.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn {

/// Keeps the id of our island set in a sink: after a power cycle a sink has its compiled-in id again, and does not
/// report it (wsn.md 9.1).
class IslandIdKeeper {
 public:
  using SendCall = std::function<Result<void>(sink::Outgoing)>;
  /// Minimum time between two corrections.
  static constexpr Duration kMinPause = std::chrono::seconds(5);

  IslandIdKeeper(std::uint16_t island, Scheduler& scheduler, SendCall send)
      : island_(island), scheduler_(scheduler), send_(std::move(send)) {}

  /// The SET_ISLAND_ID packet; also the first packet after each opening of the line.
  Bytes packet() const;
  /// Sends the id periodically from now on; nullopt: not any longer.
  void repeat(std::optional<Duration> period);
  bool repeats() const { return next_.pending(); }
  /// Sends the id now, because the sink seems to have another one; does nothing within kMinPause of the last call.
  void correct();

 private:
  std::uint16_t island_;
  Scheduler& scheduler_;
  SendCall send_;
  std::optional<SteadyTime> corrected_;
  Timer next_;
};

}  // namespace rubicon::networks::wsn
