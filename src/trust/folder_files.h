#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/own_file.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/secret_text.h"

namespace rubicon::trust {

/// The group whose people use the member `local` of a host; nullopt: this host has none.
std::optional<gid_t> people_group();

/// Who may read a key.
enum class KeyReaders : std::uint8_t {
  kOwner,   ///< only its owner
  kPeople,  ///< people_group() too, if the host has it: the key of `local`
};

/// A process that changes a folder holds a lock on this file in it.
inline constexpr const char* kLockFile = "lock";
/// How long a program waits for another one that changes the folder.
inline constexpr Duration kLockPatience = std::chrono::seconds(5);

/// The files of a trust folder. Names are relative to it (`members/desk/key.pem`). No part of a name may be a symbolic
/// link; the folder itself may. Errors begin with the whole path.
class FolderFiles {
 public:
  explicit FolderFiles(std::filesystem::path root) : root_(std::move(root)) {}

  std::string path(const std::string& name) const { return (root_ / name).string(); }
  /// An ordinary file of at most `largest` bytes that only its owner may write. kNotFound: there is none; kRefused: a
  /// symbolic link, writable by others, or not readable for this user.
  Result<std::string> read(const std::string& name, std::size_t largest) const;
  /// A file that others cannot read: owned by this user or root, no access for others, none for a group but
  /// people_group() if that is asked for.
  Result<SecretText> read_key(const std::string& name, KeyReaders readers = KeyReaders::kPeople) const;
  bool exists(const std::string& name) const;
  /// kNotFound, `<path>: <absent>`: there is none. Other errors: this user cannot see whether there is one.
  Result<void> check_exists(const std::string& name, std::string_view absent) const;
  /// Who may read this key now; kOwner also if there is none.
  KeyReaders key_readers(const std::string& name) const;
  /// The names in a folder, sorted, without those that begin with a dot. None: there is no such folder.
  std::vector<std::string> names(const std::string& folder) const;

  /// Makes the folder itself with its parents, or a folder in it. One that exists loses access that `mode` does not
  /// give; kRefused: it belongs to another user than this one or root, or others may write it.
  Result<void> make_folder(const std::string& name, mode_t mode) const;
  /// Writes a new file beside and renames it: on the disk when this returns. Only root gives a file to another owner.
  Result<void> write(const std::string& name, std::string_view text, mode_t mode, std::optional<gid_t> group = {},
                     std::optional<uid_t> owner = {}) const;
  /// Until the result is destroyed no other process gets it: a lock on the file kLockFile, which only the owner of the
  /// folder can open, so that no other user can hold it. kBusy: another process had it all of `patience`.
  Result<base::OwnFile> lock(Duration patience = kLockPatience) const;

 private:
  Result<void> check_folder(const std::string& name, mode_t mode) const;
  Result<base::OwnFile> open_folder_of(const std::string& name) const;
  Result<base::OwnFile> open_file(const std::string& name) const;
  Result<base::OwnFile> open_lock() const;
  tl::unexpected<Error> failed(const std::string& name, std::string_view what, int error) const;

  std::filesystem::path root_;
};

}  // namespace rubicon::trust
