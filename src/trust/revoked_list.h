#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/certificate.h"

namespace rubicon::trust {

/// A certificate that no longer counts.
struct RevokedCertificate {
  std::string serial;  ///< upper-case hexadecimal digits
  std::string name;
  WallTime when{};
  friend bool operator==(const RevokedCertificate&, const RevokedCertificate&) = default;
};

/// The list of revoked certificates of a realm. The authority for permissions signs it; whoever has the newest one
/// gives it to others.
struct RevokedList {
  static constexpr std::size_t kMost = 4096;  ///< certificates

  std::uint64_t number = 0;  ///< grows with each change
  std::vector<RevokedCertificate> certificates;

  const RevokedCertificate* find(std::string_view serial) const;
  bool has_name(std::string_view name) const;
  friend bool operator==(const RevokedList&, const RevokedList&) = default;
};

/// The list as a signed text (S/MIME). kBusy: it has more than kMost certificates.
Result<std::string> sign_revoked(const RevokedList& list, const Certificate& signer, const PrivateKey& key);
/// The reverse: kInvalid if another key signed it, or if it is not a list. `where` names the source in errors.
Result<RevokedList> read_revoked(std::string_view document, const Certificate& signer, std::string_view where);
/// Reads the text inside of the signature.
Result<RevokedList> parse_revoked(std::string_view json, std::string_view where);

}  // namespace rubicon::trust
