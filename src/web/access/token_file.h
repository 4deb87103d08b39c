#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "transport/transports.h"
#include "web/exchange.h"

namespace rubicon::web::access {

using Digest = std::array<std::uint8_t, 32>;

/// FIPS 180-4.
Digest sha256(std::string_view bytes);
/// Takes the same time for all inputs.
bool same(const Digest& a, const Digest& b);
std::string hex(const std::uint8_t* bytes, std::size_t size);
/// 128 random bits in 32 hexadecimal digits, from the system's source.
std::string random_secret();

/// One line of a token file: `name:role:hash`, or with names of roles for rules (docs/rights.md) behind the role:
/// `name:command,panel:hash`. The file has only a hash of the token: the token
/// itself is with its user.
struct Token {
  std::string name;
  Role role = Role::kView;
  Digest hash{};  ///< SHA-256 of the text of the token
  std::vector<std::string> roles{};

  friend bool operator==(const Token&, const Token&) = default;
};

/// `view`, `command`, `admin`; `none`.
std::string_view to_string(Role role);
/// nullopt for anything but view, command and admin.
std::optional<Role> parse_role(std::string_view word);

/// Lines of tokens, empty lines, and comments from `#` on. kInvalid with the number of the first wrong line;
/// kDuplicate for a name that stands twice.
Result<std::vector<Token>> parse_tokens(std::string_view text);
/// Reads a file of at most 1 MiB. The path is in each error.
Result<std::vector<Token>> read_tokens(transport::Transports& transports, const std::string& path);

/// What rules may call the users of these tokens: names, and roles of both kinds.
std::vector<std::string> names_of(const std::vector<Token>& tokens);

/// Appends the line of a new random token to the file, which is made (0640) if it does not exist. The token.
Result<std::string> add_token(transport::Transports& transports, const std::string& path, const std::string& name,
                              Role role);

}  // namespace rubicon::web::access
