#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::trust::site {

/// Where a host keeps its part in a realm of brokers.
inline constexpr const char* kHostSiteFolder = "/etc/rubicon/realm";

/// Which member of a realm a process is, and where its files are.
struct SitePlace {
  std::filesystem::path folder = kHostSiteFolder;
  std::string user;  ///< a name below members/
  /// A folder of the process where it keeps the newest realm if it may not write `folder`; empty = none.
  std::filesystem::path state{};

  std::string authority() const;    ///< path of the CA certificate, for transport::MqttTls
  std::string certificate() const;  ///< the user has no such file if it has a password
  std::string key() const;
  std::string password() const;  ///< the same the other way round
  bool has_password() const;
};

/// The folder of the person who runs a program: ~/.config/rubicon/realm. Empty: there is no $HOME.
std::filesystem::path own_site_folder();
/// $RUBICON_REALM (`no`, or a folder), else that of the person, else that of the host. nullopt: none has a realm.
std::optional<std::filesystem::path> site_folder_of_user();

/// The member that an island of this host is: the one that the realm names for its id. kNotFound: its key is not here,
/// or the realm names nobody. kRefused: others may use its key.
Result<SitePlace> site_place_of_island(const std::filesystem::path& folder, OwnerId island, WallTime now);
/// The member that people of this host are: the only one whose key this user may read, that of no island before others.
/// kNotFound: none. kDuplicate: two.
Result<SitePlace> site_place_of_people(const std::filesystem::path& folder, WallTime now);

}  // namespace rubicon::trust::site
