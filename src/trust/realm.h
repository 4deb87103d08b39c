#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/certificate.h"
#include "trust/operations.h"
#include "trust/revoked_list.h"

namespace rubicon::trust {

/// What all members of a realm know: the certificates of both authorities.
struct Realm {
  Certificate identity_ca, permissions_ca;

  RealmIdentity identity() const;
  friend bool operator==(const Realm&, const Realm&) = default;
};

/// A text and where it is from, for errors: the path of a file, or the part of a bundle.
struct Paper {
  std::string text, where;
};

/// All that a member shows and knows, besides its key.
struct Papers {
  Paper identity_ca, permissions_ca, governance, revoked;  ///< the same for all members
  Paper certificate, permissions;
};

/// Papers that are whole, belong together, and are valid at the time of the check.
struct CheckedPapers {
  Realm realm;
  RevokedList revoked;
  Certificate certificate;
  tuples::Member member;
};

/// Checks the papers that are the same for all members.
Result<Realm> check_realm(const Papers& papers, WallTime now);
/// Checks all of them. The revoked list may name the member: ask it.
Result<CheckedPapers> check_papers(const Papers& papers, WallTime now);

/// The name with a random end: `Rubicon 5f1c`. kInvalid: expected 1..40 letters, digits, blanks, `-`, `_`, `.`.
Result<std::string> new_realm_name(const std::string& name);

/// Both keys of a realm.
struct Authority {
  Realm realm;
  PrivateKey identity_key, permissions_key;

  /// A new realm, `name` with a random end.
  static Result<Authority> make(const std::string& name, WallTime now);
  /// A member as it will be certified, with its papers: certificate and permissions only.
  Result<Papers> certify(const CertificateOrder& order) const;
};

}  // namespace rubicon::trust
