#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "trust/site/site_operations.h"

namespace rubicon::trust::site {

inline constexpr std::size_t kMaxSiteBundle = 512UL * 1024;  ///< bytes

/// What a member takes to its host in one file (`NAME.trust`).
struct SiteBundle {
  std::string authority;             ///< certificate in PEM
  std::string realm;                 ///< the signed realm file
  std::string certificate;           ///< in PEM; empty = the member has a password
  std::string key;                   ///< PrivateKey::encrypted(); empty = it is on that host already
  std::string user, password_hash;   ///< of a member with a password
  std::vector<std::string> brokers;  ///< HOST:PORT
};

/// JSON, with one line for each part.
std::string bundle_text(const SiteBundle& bundle);
/// Reads the form only. kInvalid: no such file, one of DDS, or a key that no pass phrase protects.
Result<SiteBundle> read_site_bundle(std::string_view text);

/// What the realm and the folder know of a member.
ListedSiteMember listed_member(const SiteFolder& folder, const SiteRealm& realm, const std::string& name);

}  // namespace rubicon::trust::site
