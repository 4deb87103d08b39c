#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/config_reader.h"

namespace rubicon::config {

/// `audit:`: the lines about what others asked for (docs/rights.md).
struct AuditSetup {
  std::string file{};                ///< as configured; empty = beside the state file
  std::vector<std::string> hide{};   ///< tuples whose values are left out, as the keys of rules
  std::uint64_t size = 100'000'000;  ///< bytes of all its files

  friend bool operator==(const AuditSetup&, const AuditSetup&) = default;
};

inline constexpr std::uint64_t kSmallestAudit = 1'000'000;  ///< bytes

/// Reads `audit:`; what is wrong stands in the reader's errors.
AuditSetup read_audit(ConfigReader& root);

}  // namespace rubicon::config
