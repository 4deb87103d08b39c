#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/scheduler.h"

namespace rubicon::motes_simulator {

/// An event inside the simulated world, which a computer at a sink cannot observe.
struct Event {
  Duration at{};           ///< since the start of the world
  std::string_view what;   ///< `executed`, `joined`, ...: listed in docs/motes-simulator.md
  std::uint16_t sink = 0;  ///< 1, 2, ...; 0 = none
  std::uint16_t mote = 0;  ///< address; 0 = none
  std::optional<std::uint16_t> sequence;
  std::optional<std::int64_t> value;
  Bytes record;  ///< of what was executed or ignored
};

/// One line of JSON without line end: `{"at":1.234567,"event":"executed","sink":1,"mote":2,...}`, times in seconds.
std::string to_json(const Event& event);

/// Collects the events of a world; costs nothing without a callback.
class EventLog {
 public:
  using Callback = std::function<void(const Event&)>;

  EventLog(Scheduler& scheduler, Callback callback)
      : scheduler_(scheduler), start_(scheduler.now()), callback_(std::move(callback)) {}

  explicit operator bool() const { return static_cast<bool>(callback_); }
  void operator()(Event event) const {
    if (!callback_) return;
    event.at = scheduler_.now() - start_;
    callback_(event);
  }

 private:
  Scheduler& scheduler_;
  SteadyTime start_;
  Callback callback_;
};

}  // namespace rubicon::motes_simulator
