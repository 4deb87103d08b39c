#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/trust_folder.h"

namespace rubicon::trust {

/// A certificate that the authority made.
struct LedgerEntry {
  std::string name, serial;
  WallTime ends{};
};

/// What the authority of a realm gave away: all certificates, hence all names, and blocks of ids. Names and blocks are
/// never given twice.
class Ledger {
 public:
  /// A new realm's: empty.
  Ledger() = default;
  /// kInvalid also if it does not have what the members of the folder have; of those whose certificates cannot be read
  /// it has to have the names.
  static Result<Ledger> read(const TrustFolder& folder);
  Result<void> write(const TrustFolder& folder) const;

  /// Letters of either case are the same here, as in subjects of certificates.
  bool has_name(std::string_view name) const;
  std::vector<LedgerEntry> of_name(std::string_view name) const;
  void add(LedgerEntry entry) { entries_.push_back(std::move(entry)); }
  /// The next block of ids; kBusy: all are given away.
  Result<std::uint32_t> take_block();

 private:
  Result<void> check_member(const tuples::Member& member, const TrustFolder& folder) const;

  std::vector<LedgerEntry> entries_;
  std::uint32_t last_block_ = 0;
};

}  // namespace rubicon::trust
