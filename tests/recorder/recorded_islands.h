#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "island/island.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::recorder {

/// What a reader sees of a tuple but for its write time.
struct Seen {
  std::string value, media_type;
  WallTime user_time{};
  friend bool operator==(const Seen&, const Seen&) = default;
};
std::ostream& operator<<(std::ostream& out, const Seen& seen);

/// An island of YAML in virtual time on a disk of memory, with a component that subscribes to everything.
class TestIsland {
 public:
  /// Errors of the configuration fail the test.
  TestIsland(const std::string& yaml, transport::MemoryTransports& disk, bool demand = true);

  void run(Duration span) { time.run_for(span); }
  /// Sets a tuple of the island and lets it happen.
  void command(const std::string& key, const std::string& value);
  /// Values and descriptions of the points and devices of a network.
  std::map<std::string, Seen> picture(const std::string& network);
  /// The values each point had, one after the other.
  const std::map<std::string, std::vector<Seen>>& history() const { return history_; }

  VirtualScheduler time;
  support::CollectingLog log;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<island::Island> island;

 private:
  std::map<std::string, std::vector<Seen>> history_;
  tuples::Handle ears_;
};

}  // namespace rubicon::recorder
