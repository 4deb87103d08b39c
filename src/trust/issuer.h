#pragma once

#include <string>
#include <vector>

#include "rubicon/result.hpp"
#include "trust/ledger.h"
#include "trust/operations.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {

/// The authority of a folder at work: has the folder for itself until it is destroyed.
class Issuer {
 public:
  /// kDuplicate: the folder has a realm already.
  static Result<Issuer> create(const std::filesystem::path& root, const std::string& realm, WallTime now);
  static Result<Issuer> open(const std::filesystem::path& root, WallTime now);

  const TrustFolder& folder() const { return folder_; }
  const Authority& authority() const { return authority_; }
  const Ledger& ledger() const { return ledger_; }

  /// Whether a member with this key can be added so. A name is free also if its certificate was never written, and the
  /// folder has this key for it.
  Result<void> check(const MemberOptions& options, const EVP_PKEY* key) const;
  /// All papers of a new member, which are in the folder too.
  Result<Papers> certify(const MemberOptions& options, EVP_PKEY* key);
  /// The same for a member that has ids and roles already.
  Result<Papers> certify_again(const tuples::Member& member, EVP_PKEY* key, int days);

 private:
  Issuer(TrustFolder folder, base::OwnFile lock, Authority authority, Ledger ledger, WallTime now)
      : folder_(std::move(folder)),
        lock_(std::move(lock)),
        authority_(std::move(authority)),
        ledger_(std::move(ledger)),
        now_(now) {}
  Result<void> check_meanings(const MemberOptions& options) const;
  Result<void> check_island(const MemberOptions& options) const;
  Result<RevokedList> revoked() const;
  /// Whether a certificate of that name has neither ended nor been revoked.
  bool is_in_force(const std::string& name, const RevokedList& revoked) const;
  /// The process ended between the note of the certificate and its file: it never left this host.
  bool was_cut_short(const std::string& name, const EVP_PKEY* key) const;

  TrustFolder folder_;
  base::OwnFile lock_;
  Authority authority_;
  Ledger ledger_;
  WallTime now_;
};

/// A member is an island's if it has an id of one.
bool is_island_member(const tuples::Member& member);
/// kInvalid: the people of the host must not use the key of this member.
tl::unexpected<Error> key_of_island(const std::string& name);

}  // namespace rubicon::trust
