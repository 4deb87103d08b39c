#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::model {

/// A problem keeps something from working; a warning concerns one device, or what will fail later.
enum class Severity : std::uint8_t { kProblem, kWarning };
std::string_view to_string(Severity severity);

/// What of an island needs a person.
struct Alert {
  std::string kind;   ///< for programs, never another word: `line-down`, `battery-low` (docs/running.md lists them)
  std::string about;  ///< key of the network, device or point: `proxy.wsn-1.7`; the prefix for the island itself
  Severity severity = Severity::kWarning;
  WallTime since{};  ///< zero from a source that does not know it
  std::string what;  ///< one sentence, with the name of the device
  std::string fix;   ///< what to do

  friend bool operator==(const Alert&, const Alert&) = default;
};

/// The tuple `<prefix>.alerts` of an island (docs/tuple-keys.md): the first kMaxAlerts alerts, and how many more there
/// are.
class AlertList {
 public:
  static constexpr std::size_t kMaxAlerts = 200;

  /// `make` returns the alert, and is called only while there is room.
  template <class Make>
  void add(Make make) {
    if (all.size() < kMaxAlerts) {
      all.push_back(make());
    } else {
      ++more;
    }
  }

  std::vector<Alert> all;
  std::uint64_t more = 0;

  friend bool operator==(const AlertList&, const AlertList&) = default;
};

/// Times are seconds since 1970 UTC. Longer texts are cut to 500 bytes.
std::string alerts_to_json(const AlertList& list);
/// Empty for what is no such object; entries that are no objects are left out. A severity that is not known is a
/// warning.
AlertList alerts_from_json(std::string_view text);

}  // namespace rubicon::model
