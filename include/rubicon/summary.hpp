#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::model {

/// What a component says of itself to everybody, without being asked (docs/ecology.md, "Who is there").
struct Summary {
  std::string name;                                 ///< for people
  std::string host;                                 ///< of the machine it runs on
  std::string program;                              ///< `rubicon-proxy 0.1.0`
  std::string prefix;                               ///< of an island: the first part of its keys; else empty
  WallTime since{};                                 ///< when it started
  std::map<std::string, std::uint64_t> networks{};  ///< of an island: how many devices each lists

  friend bool operator==(const Summary&, const Summary&) = default;
};

/// One line of JSON, shorter than kMaxSummary: networks that do not fit are left out.
std::string to_json(const Summary& summary);
/// kInvalid when it is no JSON object; members that are missing or of another kind are empty.
Result<Summary> summary_from_json(std::string_view text);

}  // namespace rubicon::model

namespace rubicon {
using model::Summary;
}  // namespace rubicon
