#pragma once

#include <map>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/secret_text.h"

namespace rubicon::trust::site {

/// A password as mosquitto 2 keeps it: PBKDF2 with HMAC-SHA-512, `$7$<rounds>$<salt>$<hash>` (mosquitto_passwd(1)).
/// The passwords are random and of 120 bits: few rounds do.
Result<std::string> password_hash(std::string_view password);
/// Whether it is the password of that hash; false for what is no such hash.
bool is_password_of(std::string_view password, std::string_view hash);
/// A phrase as it was shown, whatever blanks and capitals it was typed with: in groups of 4 with `-`.
SecretText spelled_phrase(std::string_view typed);

/// The lines of a password file of mosquitto: hashes by user.
using PasswordLines = std::map<std::string, std::string, std::less<>>;
/// kInvalid: a user whose name is no level of a topic (check_user_name()), or a line without a hash.
Result<PasswordLines> parse_passwords(std::string_view text, std::string_view where);
std::string passwords_text(const PasswordLines& lines);

}  // namespace rubicon::trust::site
