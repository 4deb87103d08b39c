#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::trust {

/// Where a host keeps its trust unless something else is configured.
inline constexpr const char* kHostFolder = "/etc/rubicon/trust";
/// The member whose key the people of a host may use: group `rubicon`.
inline constexpr const char* kLocalMember = "local";

/// Which trust a process uses.
struct Place {
  std::filesystem::path folder = kHostFolder;
  std::string member;         ///< a name below members/
  std::filesystem::path key;  ///< empty = key.pem of the member; systemd hands it to units elsewhere (LoadCredential=)
  /// A folder of the process where it keeps the newest revoked list if it may not write the trust folder; empty = none.
  std::filesystem::path state;
};

/// The folder of the person who runs a program: ~/.config/rubicon/trust. Empty: there is no $HOME.
std::filesystem::path user_folder();

/// The folder of place_of_user(), without a look at what is in it. nullopt: there is none.
std::optional<std::filesystem::path> folder_of_user();
/// The place for the person who runs a tool. $RUBICON_TRUST comes first (`no`, or a folder), then
/// ~/.config/rubicon/trust, then the host's folder. The member is that of choose_member_of_people(). nullopt: there is
/// none, tools work without trust. kRefused: there is one that this user may not enter or read; the text says how to
/// join the group.
Result<std::optional<Place>> place_of_user();
/// The same for one folder.
Result<Place> place_in(const std::filesystem::path& folder);
/// The place of an island: the member of choose_member_of_island(). The key of systemd's credential `trust-key` comes
/// before that of the folder. kRefused: it is `none`, and this user may not read that of the folder.
Result<Place> place_of_island(const std::filesystem::path& folder, OwnerId island);
/// The key, if this user may not read it.
std::optional<std::filesystem::path> hidden_key(const Place& place);
/// Whether an island has trust if its configuration does not say: $RUBICON_TRUST, else whether the host's folder
/// exists, or cannot be seen, which is an error to find out. nullopt: no.
std::optional<std::filesystem::path> default_folder();

}  // namespace rubicon::trust
