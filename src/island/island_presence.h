#pragma once

#include <functional>
#include <string>

#include "base/scheduler.h"
#include "rubicon/summary.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// What the others see of this island without asking, and `<prefix>.islands`, its list of those it sees: both at most
/// once a second, a few times in its first one, and only what changed.
class IslandPresence {
 public:
  /// How many devices each network lists.
  using Count = std::function<std::map<std::string, std::uint64_t>()>;

  IslandPresence(Scheduler& scheduler, TupleSpace& space, std::string name, std::string prefix, Count count);

  void start();

 private:
  void refresh();
  void list_islands();
  std::string islands() const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  Count count_;
  Summary summary_;
  std::string described_, listed_;
  Duration pause_{};
  Timer timer_;
};

}  // namespace rubicon::island
