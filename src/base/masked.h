#pragma once

#include <string>
#include <string_view>

namespace rubicon::base {

// Secrets in texts that all components may read: the configuration in force, the lines of the log.

inline constexpr std::string_view kMasked = "****";

/// Whether an option of this name holds a secret: `password`, `api-key`, `web.token`. The path of a file and the name
/// of an environment variable (`password-file`, `password-env`) are none.
bool names_secret(std::string_view option);

/// The text with `****` for the password of each URL, what follows `Bearer`, and the value behind each name of a secret
/// (`password=...`, `token: ...`), up to a blank, a comma, a quote or a bracket.
std::string masked(std::string_view text);

}  // namespace rubicon::base
