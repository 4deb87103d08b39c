#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "base/scheduler.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn {

/// Keeps a sink on our island: a sink that was switched off is on the island that was compiled in, and tells nobody
/// (wsn.md 9.1).
class IslandIdKeeper {
 public:
  using SendCall = std::function<Result<void>(sink::Outgoing)>;
  /// A sink that shows another island, or nothing where something is due, is corrected at once, but not more often.
  static constexpr Duration kPause = std::chrono::seconds(5);

  IslandIdKeeper(std::uint16_t island, Scheduler& scheduler, SendCall send)
      : island_(island), scheduler_(scheduler), send_(std::move(send)) {}

  /// SET_ISLAND_ID: also the first packet after each opening.
  Bytes packet() const;
  /// Tells it each so often from now on; nullopt = no more.
  void watch(std::optional<Duration> period);
  bool watched() const { return next_.pending(); }
  void correct();

 private:
  std::uint16_t island_;
  Scheduler& scheduler_;
  SendCall send_;
  std::optional<SteadyTime> corrected_;
  Timer next_;
};

}  // namespace rubicon::networks::wsn
