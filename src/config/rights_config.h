#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "rights/rights.h"

namespace rubicon::config {

/// `rights:`: who may do what with which tuples.
struct RightsSetup {
  std::vector<rights::Rule> rules;
  ConfigPlace place{};  ///< of the section

  friend bool operator==(const RightsSetup& a, const RightsSetup& b) { return a.rules == b.rules; }
};

/// More rules are an error: each is compared with each member.
inline constexpr std::size_t kMaxRules = 10'000;

/// nullopt = the file has no such section. Everything wrong is in the reader's errors.
std::optional<RightsSetup> read_rights(ConfigReader& root);

/// `audit:`: the lines about what others asked for (docs/rights.md).
struct AuditSetup {
  std::string file{};                ///< as configured; empty = beside the state file
  std::vector<std::string> hide{};   ///< tuples whose values are left out, as the keys of rules
  std::uint64_t size = 100'000'000;  ///< bytes of all its files

  friend bool operator==(const AuditSetup&, const AuditSetup&) = default;
};

inline constexpr std::uint64_t kMinAudit = 1'000'000;  ///< bytes

/// Reads `audit:`; what is wrong stands in the reader's errors.
AuditSetup read_audit(ConfigReader& root);

}  // namespace rubicon::config
