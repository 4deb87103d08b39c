#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "console/live_source.h"

namespace rubicon::console {

/// Devices below their networks, or one list of all: by name, the last heard first, or those in trouble first.
enum class LiveSort : std::uint8_t { kNetwork, kName, kLatest, kTrouble };
std::string_view to_string(LiveSort sort);

/// What of an island is shown, and in which order.
struct LiveChoice {
  std::string filter;  ///< words that must all stand in a row or above it; case does not matter
  LiveSort sort = LiveSort::kNetwork;
  std::set<std::string> folded;  ///< ids of networks and keys of devices of which nothing below is shown
};

struct LiveRow {
  enum class Kind : std::uint8_t { kNetwork, kDevice, kPoint };
  Kind kind = Kind::kPoint;
  std::string key;  ///< of a network its id

  friend bool operator==(const LiveRow&, const LiveRow&) = default;
};

/// The rows of the whole table. Folds do not hide what a filter finds.
std::vector<LiveRow> live_rows(const LiveSource& source, const LiveChoice& choice);

}  // namespace rubicon::console
