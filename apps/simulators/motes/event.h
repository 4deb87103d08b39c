#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/scheduler.h"

namespace rubicon::motes_simulator {

/// Something that happened in the simulated world, as no computer at a sink can see it.
struct Event {
  Duration at{};           ///< since the world began
  std::string_view what;   ///< `executed`, `joined`, ...: docs/motes-simulator.md has them all
  std::uint16_t sink = 0;  ///< 1, 2, ...; 0 = none
  std::uint16_t mote = 0;  ///< address; 0 = none
  std::optional<std::uint16_t> sequence;
  std::optional<std::int64_t> value;
  Bytes record;  ///< of what was executed or ignored
};

/// One line of JSON without its end: `{"at":1.234567,"event":"executed","sink":1,"mote":2,...}`, times in seconds.
std::string to_json(const Event& event);

/// Where the parts of a world put their events; costs nothing while nobody listens.
class EventLog {
 public:
  using Call = std::function<void(const Event&)>;

  EventLog(Scheduler& scheduler, Call call) : scheduler_(scheduler), began_(scheduler.now()), call_(std::move(call)) {}

  explicit operator bool() const { return static_cast<bool>(call_); }
  void operator()(Event event) const {
    if (!call_) return;
    event.at = scheduler_.now() - began_;
    call_(event);
  }

 private:
  Scheduler& scheduler_;
  SteadyTime began_;
  Call call_;
};

}  // namespace rubicon::motes_simulator
