#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "networks/knx/secure/key.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx::secure {

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
