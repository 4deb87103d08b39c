#pragma once

#include <map>
#include <string>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::cli {

/// How often things happened, round by round.
class Rates {
 public:
  void count(const std::string& name, WallTime when);

  struct Row {
    std::string name;
    double per_second = 0;    ///< in the last round
    std::uint64_t total = 0;  ///< since the start
    WallTime last{};
  };
  /// Ends a round of this length: the busiest first, then by name.
  std::vector<Row> round(Duration length);

 private:
  struct Entry {
    std::uint64_t total = 0, now = 0;
    WallTime last{};
  };
  std::map<std::string, Entry> entries_;
};

/// What a tuple is counted as: `tuple`, `device` (`6541:proxy.wsn-1.7`), `network` or `island`. What has fewer parts
/// counts as itself.
std::string group_of(std::string_view name, std::string_view by);

}  // namespace rubicon::cli
