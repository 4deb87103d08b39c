#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "tuples/tuple_space.h"

namespace rubicon::runtime {

/// Publishes the island's own numbers as `<prefix>.property.<name>.value`: queues, drops, what the state file and the
/// recorders do. Once a second, and only what changed.
class IslandMetrics {
 public:
  /// Says one number; names are `[a-z-]+`.
  using Say = std::function<void(const std::string& name, std::uint64_t value)>;
  using Source = std::function<void(const Say& say)>;

  IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix);

  /// Asked each time; what it uses must live as long as this.
  void add(Source source) { sources_.push_back(std::move(source)); }
  void start();

 private:
  void publish();

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string prefix_;
  std::vector<Source> sources_;
  std::map<std::string, std::uint64_t> published_;
  Timer timer_;
};

}  // namespace rubicon::runtime
