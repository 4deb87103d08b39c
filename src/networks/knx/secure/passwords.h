#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/secure/key.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx::secure {

/// The key of a password. Interfaces disagree on letters beyond ASCII (knx.md, section 21.4): most take ISO 8859-1,
/// some replace each of them by `?`, some each of its bytes in UTF-8.
struct PasswordKey {
  Key key;
  /// With these replacements; only for a password that has such letters. To be tried in turn after `key` was refused.
  std::vector<Key> others{};

  /// 1 without letters beyond ASCII.
  std::size_t forms() const { return 1 + others.size(); }
  const Key& form(std::size_t index) const { return index == 0 || others.empty() ? key : others.at(index - 1); }
};

/// From a password in UTF-8. Each key takes PBKDF2 (some 15 ms): not for the event loop. A password that ISO 8859-1
/// cannot write (`€`) has only the keys of the replacements. kInvalid: not UTF-8; the error never holds the password.
Result<PasswordKey> user_key(const Secret& password);
/// Proves the interface to us: "authentication code" of the device in ETS.
Result<PasswordKey> device_code(const Secret& password);

/// What ETS 6 gives to the archive of a protected project as its password (knx.md, section 13.4): 44 characters of
/// base64 from a password in UTF-8. One PBKDF2. kInvalid: not UTF-8.
Result<Secret> archive_password(const Secret& password);

/// The variable that the tools of the command line take a password from, if no file is named.
inline constexpr const char* kPasswordVariable = "RUBICON_KNX_PASSWORD";

/// The content of a file of at most `largest` bytes that is private (FileSource::open_to_others): kRefused otherwise,
/// with the chmod that changes it. kOutOfRange: it is larger; else the errors of the file. `what` names the content in
/// errors, which never hold it. Blocks: for start-up and tools.
Result<Secret> read_private_file(transport::Transports& transports, const std::string& path, std::size_t largest,
                                 std::string_view what);

/// Reads a file of one line with a password of at most 1,024 bytes, with or without the mark that UTF-8 files of
/// Windows begin with. kRefused if it is not private, with the chmod that changes it; kInvalid: empty or several
/// lines; else the errors of the file. No error holds the password. Blocks: for start-up and tools.
Result<Secret> read_password_file(transport::Transports& transports, const std::string& path);

/// From the file, else (path empty) from an environment variable; nullopt if there is neither. A command line has no
/// passwords: other users see it.
Result<std::optional<Secret>> find_password(transport::Transports& transports, const std::string& path,
                                            const char* variable);

/// For the end of an error about a password that find_password() gave: where it is from, and whether blanks around it
/// may be the reason. Nothing of the password itself.
std::string password_source(const Secret& password, const std::string& path, const char* variable = kPasswordVariable);

}  // namespace rubicon::networks::knx::secure
