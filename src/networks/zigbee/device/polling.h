#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/scheduler.h"

namespace rubicon::networks::zigbee::device {

/// When a device that can be asked is asked: once where its values are needed, and periodically where a subscriber
/// wants them more often than it reports (zigbee.md, section 9). At most once a second; a question that finds no place
/// in the bound of the network waits.
class Polling {
 public:
  static constexpr Duration kMinTime = std::chrono::seconds(1);

  /// Publishes one get for these properties; false: no place in this moment.
  using Ask = std::function<bool(const std::vector<std::size_t>& properties)>;
  /// `retry` after a question that found no place; different for each device, so that they take turns.
  Polling(Scheduler& scheduler, Duration retry, Ask ask);

  /// Asks once for these, as soon as possible.
  void once(const std::vector<std::size_t>& properties);
  /// Asks for these, and again each period; replaces the demand before. Zero, or none: no longer.
  void demand(std::vector<std::size_t> properties, Duration period);
  /// Forgets all: the properties have other indexes from now on.
  void clear();
  /// Without a line nothing is asked; the demand stays.
  void line(bool up);

 private:
  void step();
  void schedule();

  Scheduler& scheduler_;
  Duration retry_;
  Ask ask_;
  std::set<std::size_t> once_;
  std::vector<std::size_t> demanded_;
  Duration period_{};
  SteadyTime next_poll_ = SteadyTime::max();
  SteadyTime not_before_{};
  bool up_ = false;
  base::Deadline deadline_;
};

/// The limit for the silence of a device whose availability Zigbee2MQTT does not publish (zigbee.md, section 6). A
/// device that can be asked is asked before, because many report only changes.
class Silence {
 public:
  /// For the answer to a question whether the device is there.
  static constexpr Duration kProbeTime = std::chrono::seconds(15);

  struct Callbacks {
    std::function<bool()> ask;  ///< false: no place in this moment
    std::function<void(std::string reason)> unreachable;
  };
  Silence(Scheduler& scheduler, Callbacks calls);

  /// nullopt: no limit.
  void limit(std::optional<Duration> limit, bool can_ask);
  /// The device was heard, so long ago.
  void heard(Duration ago);
  /// Its silence counts from now on; false: the line is down.
  void line(bool up);

 private:
  enum class Phase : std::uint8_t { kHeard, kAsked, kUnreachable };
  void due();
  void schedule();

  Scheduler& scheduler_;
  Callbacks callbacks_;
  std::optional<Duration> limit_;
  bool can_ask_ = false, up_ = false;
  Phase phase_ = Phase::kHeard;
  SteadyTime heard_at_{};
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::zigbee::device
