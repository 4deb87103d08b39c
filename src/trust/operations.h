#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/folder_files.h"
#include "trust/secret_text.h"
#include "tuples/member.h"

namespace rubicon::trust {

// What `rubicon trust` does. Each function works on a trust folder (docs/trust.md), takes the time as an argument and
// leaves files whole: all of a file is new, or nothing. Only one process at a time changes a folder; a second one waits
// for kLockPatience, then gets kBusy. Errors name the file, what is wrong and what was expected, and hold nothing
// secret.

inline constexpr int kMemberDays = 730;      ///< life of a member's certificate unless something else is asked for
inline constexpr int kMaxMemberDays = 3650;  ///< the longest life
inline constexpr int kRealmDays = 7305;      ///< life of both authorities: 20 years

/// A realm as people compare it.
struct RealmIdentity {
  std::string name;         ///< with its random end: `Rubicon 5f1c`
  std::string fingerprint;  ///< SHA-256 over both authorities: 16 groups of 4 upper-case digits, separated by blanks
};

struct InitOptions {
  std::string realm = "Rubicon";  ///< 1..40 letters, digits, blanks, `-`, `_`, `.`; a random end is added
  /// Islands of this host: each becomes the member `island-<id>`, whose key stays in the folder.
  std::vector<OwnerId> islands;
};

struct MemberOptions {
  std::string name;  ///< check_member_name(); unique for ever
  /// For an island: the certificate holds this id and a block. kNoOwner: a block only.
  OwnerId island{};
  std::vector<std::string> roles;  ///< check_role()
  int days = kMemberDays;          ///< 1..kMaxMemberDays; never longer than the authority
};

/// A member and what it needs on its host.
struct Issued {
  tuples::Member member;
  RealmIdentity realm;
  std::string bundle;  ///< the text of the file `<name>.trust`
  /// Opens the key in the bundle; shown once, kept by no one. Empty: the bundle has no key.
  SecretText phrase;
};

/// One member of a folder.
struct ListedMember {
  tuples::Member member;  ///< of its newest certificate
  int days_left = 0;      ///< until that ends, rounded down; negative afterwards
  bool has_key = false;   ///< its key lies in this folder
  std::optional<WallTime> revoked;
};

/// A member whose certificate cannot be read.
struct UnreadableMember {
  std::string name;
  std::string reason;  ///< begins with the path of the file
  bool revoked = false;
};

struct FolderContents {
  RealmIdentity realm;
  bool has_authority = false;  ///< members can be added here
  int authority_days_left = 0;
  std::uint64_t revoked_number = 0;  ///< of the list of revoked certificates; grows with each revocation
  std::vector<ListedMember> members;
  std::vector<UnreadableMember> unreadable;
};

/// The people of a host, `local`: role admin.
MemberOptions member_of_people();
/// `island-<id>`
MemberOptions member_of_island(OwnerId island);

/// Makes a realm: both authorities, governance, an empty revoked list, the member `local` (role admin) and the islands.
/// kDuplicate if the folder has a realm.
Result<RealmIdentity> init(const std::filesystem::path& folder, const InitOptions& options, WallTime now);

/// Makes a key and a certificate for another host. The key leaves in the bundle only. Certificates of other members
/// that cannot be read matter only for an island: one of them may have its id.
Result<Issued> add(const std::filesystem::path& folder, const MemberOptions& options, WallTime now);
/// The same for a member of this host: the key stays in the folder, there is no bundle. kInvalid: the key of an island
/// is not for people.
Result<tuples::Member> add_here(const std::filesystem::path& folder, const MemberOptions& options, WallTime now,
                                KeyReaders readers = KeyReaders::kOwner);

/// What a bundle holds, checked as join() does, without the phrase: to show the fingerprint before the question.
struct BundleContents {
  RealmIdentity realm;
  tuples::Member member;
  bool has_key = false;
};
Result<BundleContents> inspect(std::string_view bundle, WallTime now);

/// What becomes of a bundle whose certificate ends before that of the same member in the folder.
enum class Older { kRefuse, kTake };
/// Writes the member of a bundle into a folder. The folder may be new, or belong to the same realm. A bundle without a
/// key needs the key in the folder: of request(), or of the certificate before. kRefused: wrong phrase. kDuplicate:
/// another realm, or an older certificate. A key that the people of the host may read stays so. kInvalid: that of an
/// island is not for people.
Result<BundleContents> join(const std::filesystem::path& folder, std::string_view bundle, std::string_view phrase,
                            WallTime now, Older older = Older::kRefuse, KeyReaders readers = KeyReaders::kOwner);

/// Makes a key in the folder, or takes that which is there, and gives the request for its certificate: PEM (PKCS 10).
Result<std::string> request(const std::filesystem::path& folder, const std::string& name);
/// SHA-256 over the public key of a request, in the form of RealmIdentity::fingerprint: people compare it on both hosts
/// before one signs.
Result<std::string> key_fingerprint(std::string_view request);
/// Answers a request: a bundle without a key. The name is that of the request if `options` has none.
Result<Issued> sign(const std::filesystem::path& folder, std::string_view request, const MemberOptions& options,
                    WallTime now);

/// Gives the key of `local` to people_group(), if it is for root only. Only root does. True: it was given now.
Result<bool> give_local_to_people(const std::filesystem::path& folder);

/// Puts all certificates of a member on the list of revoked ones. The new list, signed, is for everybody (it is in the
/// folder too). kNotFound: no such member.
Result<std::string> revoke(const std::filesystem::path& folder, const std::string& name, WallTime now);

/// A new certificate and new permissions for the same name, ids, roles and key. If the key is in the folder, the member
/// is renewed there; the bundle (without a key) is for the host of any other. kRefused: it was revoked.
Result<Issued> renew(const std::filesystem::path& folder, const std::string& name, int days, WallTime now);

/// All members in the order of their names. Works without authority too: then the members of this host. A certificate
/// that cannot be read hides no other one.
Result<FolderContents> show(const std::filesystem::path& folder, WallTime now);

/// The bundle of a member again: with its key under a new phrase if the key is in this folder, else without.
Result<Issued> export_member(const std::filesystem::path& folder, const std::string& name, WallTime now);

/// A name of a member: 1..64 letters, digits, `-`, `_`, `.`, the first one a letter or digit; not `everybody`, `peis`,
/// `all` or `admin`, which mean something else in rights.
Result<void> check_member_name(std::string_view name);
/// A role: the same characters, at most 32, and `admin` too.
Result<void> check_role(std::string_view role);

}  // namespace rubicon::trust
