#pragma once

#include <deque>
#include <map>
#include <optional>

#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Remote sets that arrived while this process catches up (catch_up.h), or whose age is not known yet, in order;
/// bounded for each component and in all.
class EarlySets {
 public:
  static constexpr std::size_t kMaxOfOne = 32UL << 20, kMaxOfAll = 64UL << 20;

  struct One {
    RemoteSet set;
    Participant sender{};
    std::uint64_t incarnation = 0;   ///< of its sender
    std::optional<Duration> sent{};  ///< by the clock of its sender (FrameTimes)
    SteadyTime since{};              ///< when it was received
  };

  /// False: the bound is reached. Then nothing of that component is added until all are taken, so that what remains is
  /// what was sent first.
  bool add(One one);
  std::deque<One> take();
  bool empty() const { return all_.empty(); }
  bool has(OwnerId from) const { return bytes_of_.contains(from); }
  void clear() { *this = {}; }

 private:
  std::deque<One> all_;
  std::map<OwnerId, std::size_t> bytes_of_;  ///< SIZE_MAX: it has no room any more
  std::size_t bytes_ = 0;
};

}  // namespace rubicon::tuples::dds
