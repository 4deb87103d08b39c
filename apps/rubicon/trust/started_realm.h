#pragma once

#include <filesystem>
#include <string>

#include "trust/folder_files.h"
#include "trust/operations.h"

namespace rubicon::cli::trust {

/// Whether the island of a configuration needs no realm of its host: it is without trust or engine dds, or has a folder
/// of its own.
bool is_without_host(const std::string& configuration);

/// Whether the island of a configuration needs no member in this folder: as before, or its folder is another one.
bool is_of_another_realm(const std::string& configuration, const std::filesystem::path& folder);

bool has_realm(const std::filesystem::path& folder);

/// The realm that islands of a host started with, in a file beside its folder: who loses the folder keeps it
/// (/etc/rubicon/trust.realm).
class StartedRealm {
 public:
  explicit StartedRealm(const std::filesystem::path& folder);

  /// kNotFound: the folder had a realm and has none now. A new one would shut out all members of the former one.
  Result<void> check_is_there() const;
  Result<void> keep(const rubicon::trust::RealmIdentity& realm) const;

 private:
  std::filesystem::path folder_;
  rubicon::trust::FolderFiles files_;
  std::string name_;
};

}  // namespace rubicon::cli::trust
