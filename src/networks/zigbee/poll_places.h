#pragma once

#include <list>
#include <string>
#include <unordered_map>

#include "base/scheduler.h"

namespace rubicon::networks::zigbee {

/// The places for polls of all devices of a network, a number per second. A caller that gets no place waits in a queue;
/// callers ahead of it get the next places.
class PollPlaces {
 public:
  /// A caller that does not ask again within this time loses its place in the queue.
  static constexpr Duration kPatience = std::chrono::seconds(2);

  PollPlaces(Scheduler& scheduler, unsigned per_second) : scheduler_(scheduler), per_second_(per_second) {}
  void per_second(unsigned most) { per_second_ = most; }

  /// Whether the device may poll now. If not, it asks again within kPatience.
  bool take(const std::string& device);

 private:
  struct Waiting {
    std::string device;
    SteadyTime asked{};
  };
  using Line = std::list<Waiting>;
  bool has_place(const std::string& device);
  void wait(const std::string& device);
  void remove(Line::iterator waiting);

  Scheduler& scheduler_;
  unsigned per_second_;
  SteadyTime second_{};  ///< begin of the second whose polls are counted
  unsigned taken_ = 0;
  Line line_;
  std::unordered_map<std::string, Line::iterator> by_device_;
};

}  // namespace rubicon::networks::zigbee
