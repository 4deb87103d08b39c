#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::trust::site {

inline constexpr std::size_t kMaxUserLength = 64;  ///< bytes; ub-common-name of RFC 5280

/// A name of a member of the realm of brokers, which is the MQTT user and a level of topics: 1..64 letters, digits,
/// `-`,
/// `_`, `.`, the first one a letter or digit. kInvalid; the text says why: characters that mean something in topics,
/// in access lists, or where one member vouches for another, and names that mean something else.
Result<void> check_user_name(std::string_view name);
/// kInvalid: a name `island-<id>` for a member that does not get this island.
Result<void> check_island_of(std::string_view name, const std::vector<OwnerId>& islands);

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
/// That of the realm whose authority is in that file; nullopt: there is no realm file beside it. `state` is that of the
/// service manager.
std::optional<SitePlace> site_place_beside(const std::string& ca_file, const std::string& user);

}  // namespace rubicon::trust::site
