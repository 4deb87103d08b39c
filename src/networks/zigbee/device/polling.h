#pragma once

#include <functional>
#include <set>
#include <vector>

#include "base/deadline.h"

namespace rubicon::networks::zigbee::device {

/// When a device that can be asked is asked: once where its values are needed, and periodically where a subscriber
/// wants them more often than it reports (zigbee.md, section 9). At most once a second; a question that finds no place
/// in the bound of the network waits.
class Polling {
 public:
  static constexpr Duration kShortest = std::chrono::seconds(1);

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

}  // namespace rubicon::networks::zigbee::device
