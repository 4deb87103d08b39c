#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "trust/certificate.h"

namespace rubicon::trust::site {

/// Bytes of the largest realm file, with its signature. A thousand members with an island and a role each take 60 kB.
inline constexpr std::size_t kMaxRealm = 256UL * 1024;

/// What the members of the brokers of a realm know of each other: who is a member, with which roles, which user an
/// island is, and who was shut out. A plain value. Whoever has the newest one hands it on: the signature counts.
struct SiteRealm {
  static constexpr std::size_t kMaxMembers = 4096;
  static constexpr std::size_t kMaxIslands = 4096;
  static constexpr std::size_t kMaxRevoked = 1024;

  using Roles = std::vector<std::string>;

  std::string name;                                   ///< as the authority spells it: `Rubicon 5f1c`
  std::uint64_t number = 0;                           ///< grows with each change
  std::map<std::string, Roles, std::less<>> members;  ///< check_user_name()
  /// Who may be each id: its island, and others that may stand in for it.
  std::set<std::pair<std::uint32_t, std::string>> islands;
  std::set<std::string, std::less<>> revoked;  ///< names, none of them in `members`

  bool is_member(std::string_view user) const { return members.find(user) != members.end(); }
  bool is_revoked(std::string_view user) const { return revoked.find(user) != revoked.end(); }
  /// None for who is no member.
  const Roles& roles_of(std::string_view user) const;
  /// Empty: nobody may be this island.
  std::vector<std::string> members_of(OwnerId island) const;
  friend bool operator==(const SiteRealm&, const SiteRealm&) = default;
};

/// JSON on one line, without signature. kBusy: more members, islands or revoked names than there may be.
Result<std::string> realm_text(const SiteRealm& realm);
/// The reverse. Members of the object that this release does not know are left out, so that a newer release can still
/// shut a member out. kInvalid: anything else than realm_text() writes. `where` names the source in errors.
Result<SiteRealm> parse_realm(std::string_view json, std::string_view where);

/// The realm file: realm_text() signed by the authority (S/MIME). kBusy also if it has more than kMaxRealm bytes.
Result<std::string> sign_realm(const SiteRealm& realm, const Certificate& authority, const PrivateKey& key);
/// The reverse: kInvalid if another key signed it, if it was changed, or is of another name than the authority.
Result<SiteRealm> read_realm(std::string_view document, const Certificate& authority, std::string_view where);

}  // namespace rubicon::trust::site
