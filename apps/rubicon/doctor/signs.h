#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"
#include "rubicon/time.hpp"

namespace rubicon::cli {

/// Whether a counter of an island or a network counts losses, by the words of its name (`dropped-readings`,
/// `state-failures`), or because KNX Secure drops what it counts (is_secure_counter()).
bool counts_loss(std::string_view name);

/// Numbers by name.
using Counters = std::map<std::string, std::uint64_t>;
/// The properties that are whole numbers.
Counters counters_of(const std::map<std::string, std::string>& properties);
/// The counters of losses that are not zero.
Counters losses_of(const Counters& counters);
/// By how much each counter is higher than before; a counter that is lower began again from zero.
Counters growth_of(const Counters& before, const Counters& now);
/// `dropped-readings 12 (+3) bad-values 1`
std::string losses_text(const Counters& losses, const Counters& growth);

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

/// An island publishes its present lines when it hears of the subscription; lines that it published before come first.
inline constexpr Duration kPresentLines = std::chrono::milliseconds(500);

/// A line of the log of an island.
struct LogLine {
  OwnerId island{};
  std::uint64_t number = 0;
  WallTime time{};
  std::string level, subject, text;
};

/// What the tuple `proxy.log.lines` holds, the oldest first.
std::vector<LogLine> log_lines_in(const tuples::TupleView& tuple);

/// Gives each line of each island once.
class NewLines {
 public:
  struct News {
    std::vector<LogLine> lines;
    std::uint64_t missed = 0;  ///< lines that came and went since the ones before
  };
  News take(const tuples::TupleView& tuple);

 private:
  std::map<OwnerId, std::uint64_t> last_;
};

}  // namespace rubicon::cli
