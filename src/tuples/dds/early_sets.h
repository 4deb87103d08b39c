#pragma once

#include <deque>
#include <map>

#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Remote sets that arrived while this process catches up (catch_up.h), in order; bounded for each component and in
/// all.
class EarlySets {
 public:
  static constexpr std::size_t kMaxOfOne = 2UL << 20, kMaxOfAll = 16UL << 20;

  struct One {
    RemoteSet set;
    Participant sender{};
    std::uint64_t incarnation = 0;  ///< of its sender
    SteadyTime since{};
  };

  /// False: the bound is reached. Then nothing of that component is added until all are taken, so that what remains is
  /// what was sent first.
  bool add(One one);
  /// All of them; those whose time to live ended are left out, of the others the rest of it remains.
  std::deque<One> take(SteadyTime now);
  bool empty() const { return all_.empty(); }
  void clear() { *this = {}; }

 private:
  std::deque<One> all_;
  std::map<OwnerId, std::size_t> bytes_of_;  ///< SIZE_MAX: it has no room any more
  std::size_t bytes_ = 0;
};

}  // namespace rubicon::tuples::dds
