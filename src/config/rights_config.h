#pragma once

#include <optional>
#include <vector>

#include "base/config_reader.h"
#include "trust/rights/rule.h"

namespace rubicon::config {

/// `rights:`: who may do what with which tuples.
struct RightsSetup {
  std::vector<trust::rights::Rule> rules;
  ConfigPlace place{};  ///< of the section

  friend bool operator==(const RightsSetup& a, const RightsSetup& b) { return a.rules == b.rules; }
};

/// More rules are an error: each is compared with each member.
inline constexpr std::size_t kMostRules = 10'000;

/// nullopt = the file has no such section. Everything wrong is in the reader's errors.
std::optional<RightsSetup> read_rights(ConfigReader& root);

}  // namespace rubicon::config
