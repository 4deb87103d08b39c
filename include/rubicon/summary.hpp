#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::model {

/// Longest text of a summary, in bytes; longer ones are rejected.
inline constexpr std::size_t kMaxSummary = 16UL * 1024;

/// The self-description of a component, which all others receive without subscribing (docs/ecology.md, "Who is there").
struct Summary {
  std::string name;                                 ///< display name
  std::string host;                                 ///< name of the machine it runs on
  std::string program;                              ///< program and version: `rubicon-proxy 0.1.0`
  std::string prefix;                               ///< of an island: first part of its keys; else empty
  WallTime since{};                                 ///< start of the component
  std::map<std::string, std::uint64_t> networks{};  ///< of an island: number of devices by network id

  friend bool operator==(const Summary&, const Summary&) = default;
};

/// Whether a component with this summary is an island. Its id does not decide: kernels of a PEIS network have ids from
/// 0 to 9999, and publish no prefix.
inline bool is_island(OwnerId id, const Summary& summary) {
  return is_island(id) && !summary.prefix.empty();
}

/// One line of JSON of at most kMaxSummary bytes; leaves all networks out if they would not fit.
std::string to_json(const Summary& summary);
/// kInvalid if the text is no JSON object. Members that are missing or of another type become empty.
Result<Summary> summary_from_json(std::string_view text);

}  // namespace rubicon::model

namespace rubicon {
using model::kMaxSummary;
using model::Summary;
}  // namespace rubicon
