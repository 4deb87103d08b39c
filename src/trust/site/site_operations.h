#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trust/site/brokers.h"
#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

// What `rubicon trust` does with the realm of brokers. Each function works on a folder (docs/sites.md), takes the time
// as an argument and leaves files whole. Only one process at a time changes a folder. Errors name the file, what is
// wrong and what was expected, and hold nothing secret.

inline constexpr int kMemberDays = 730;      ///< life of a certificate of a member unless something else is asked for
inline constexpr int kMaxMemberDays = 3650;  ///< the longest life

struct SiteInit {
  std::string realm = "Rubicon";     ///< 1..40 letters, digits, blanks, `-`, `_`, `.`; a random end is added
  std::vector<std::string> brokers;  ///< HOST or HOST:PORT
};
/// kDuplicate if the folder has a realm.
Result<RealmIdentity> init(const std::filesystem::path& folder, const SiteInit& options, WallTime now);

struct SiteMemberOptions {
  std::string name;  ///< check_user_name(); never given again
  std::vector<OwnerId> islands;
  std::vector<std::string> roles;  ///< check_role()
  int days = kMemberDays;          ///< 1..kMaxMemberDays
};

/// A member of a realm.
struct ListedSiteMember {
  std::string name;
  std::vector<std::string> roles;
  std::vector<OwnerId> islands;
  std::vector<std::string> also;  ///< other members that may be one of these, too
  bool has_password = false;      ///< instead of a certificate
  std::optional<WallTime> ends;   ///< of the newest certificate, if that is known here
  bool has_key = false;           ///< its key or password is in this folder
};

/// A member and what it needs on its host.
struct SiteIssued {
  ListedSiteMember member;
  RealmIdentity realm;
  std::string bundle;  ///< the text of the file `<name>.trust`
  /// Opens the key in the bundle, or is the password; shown once, kept by no one. Empty: neither is needed.
  SecretText phrase;
};

/// A folder of a broker after a change.
struct BrokerUpdate {
  BrokerFolder broker;
  std::optional<Error> fault;  ///< its files are as they were, and have to be written again
};

/// Makes a key and a certificate for another host. The key leaves in the bundle only.
Result<SiteIssued> add(const std::filesystem::path& folder, const SiteMemberOptions& options, WallTime now);
/// The same for a member of this host: key and certificate are in the folder, there is no bundle.
Result<ListedSiteMember> add_here(const std::filesystem::path& folder, const SiteMemberOptions& options, WallTime now,
                                  KeyReaders readers = KeyReaders::kOwner);
/// A member with a password, which each broker of the realm that takes passwords knows from its next reload on.
struct AddedPassword {
  SiteIssued issued;
  std::vector<BrokerUpdate> brokers;
};
Result<AddedPassword> add_with_password(const std::filesystem::path& folder, const SiteMemberOptions& options,
                                        WallTime now);

/// What a bundle holds, checked as join_site() does, but for the phrase.
struct SiteBundleContents {
  RealmIdentity realm;
  ListedSiteMember member;
  std::vector<std::string> brokers;  ///< HOST:PORT
  bool needs_phrase = false;
};
Result<SiteBundleContents> inspect_bundle(std::string_view bundle, WallTime now);
/// Whether to take a bundle if the folder has a certificate of the same member that ends later.
enum class Older { kRefuse, kTake };
/// Writes the member of a bundle into a folder. The folder may be new, or belong to the same realm. kRefused: wrong
/// phrase, or the member was revoked. kDuplicate: another realm, or an older certificate.
Result<SiteBundleContents> join_site(const std::filesystem::path& folder, std::string_view bundle,
                                     std::string_view phrase, WallTime now, Older older = Older::kRefuse,
                                     KeyReaders readers = KeyReaders::kOwner);

/// A new certificate for the same key, in the folder if the key is here, else in a bundle without key. With a new key
/// the former certificates are revoked. kRefused: the member was revoked. kUnsupported: it has a password.
enum class RenewKey { kKeep, kMake };
struct Renewed {
  SiteIssued issued;                  ///< without a bundle if all is in the folder
  std::vector<BrokerUpdate> brokers;  ///< after a new key
};
Result<Renewed> renew(const std::filesystem::path& folder, const std::string& name, int days, RenewKey key,
                      WallTime now);

/// Other roles or islands, where they are given; the realm is signed again.
Result<ListedSiteMember> change(const std::filesystem::path& folder, const std::string& name,
                                const std::optional<std::vector<std::string>>& roles,
                                const std::optional<std::vector<OwnerId>>& islands, WallTime now);

/// Shuts a member out: its name is on the revoked list of the realm, its certificates are on the revocation list, and
/// the brokers of this host deny it everything from their next reload on. kNotFound: no such member.
Result<std::vector<BrokerUpdate>> revoke(const std::filesystem::path& folder, const std::string& name, WallTime now);

struct SiteContents {
  RealmIdentity realm;
  bool has_authority = false;
  int authority_days_left = 0;
  std::uint64_t number = 0;
  std::vector<ListedSiteMember> members;
  std::vector<std::string> revoked;
  std::vector<std::string> hosts;     ///< of brokers; only where the authority is
  std::vector<BrokerFolder> brokers;  ///< the same
};
Result<SiteContents> contents_of(const std::filesystem::path& folder, WallTime now);

/// Writes all files of a mosquitto into its folder. Files in `conf.d` and passwords of other users stay. `hosts`
/// replace the addresses that the realm knows; none = keep them. kInvalid: no address by which members reach it is
/// known.
Result<BrokerFolder> set_up_mosquitto(const std::filesystem::path& folder, const BrokerFolder& broker,
                                      const std::vector<std::string>& hosts, WallTime now);

}  // namespace rubicon::trust::site
