#pragma once

#include <filesystem>
#include <string>

#include "trust/folder_files.h"
#include "trust/operations.h"

namespace rubicon::trust {

/// The realm that islands of a host started with, in a file beside its folder: who loses the folder keeps it
/// (/etc/rubicon/trust.realm).
class StartedRealm {
 public:
  explicit StartedRealm(const std::filesystem::path& folder);

  /// kNotFound: the folder had a realm and has none now. A new one would shut out all members of the former one.
  Result<void> check_is_there() const;
  Result<void> keep(const RealmIdentity& realm) const;

 private:
  std::filesystem::path folder_;
  FolderFiles files_;
  std::string name_;
};

/// An absolute path without a `/` at its end.
std::filesystem::path whole_path(const std::filesystem::path& folder);

}  // namespace rubicon::trust
