#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

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

}  // namespace rubicon::cli
