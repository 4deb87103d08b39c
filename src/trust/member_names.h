#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::trust {

/// A name of a member: 1..64 letters, digits, `-`, `_`, `.`, the first one a letter or digit; not `everybody`, `peis`,
/// `lan`, `all` or `admin`, which mean something else in rights.
Result<void> check_member_name(std::string_view name);
/// A role: the same characters, at most 32, and `admin` too.
Result<void> check_role(std::string_view role);

/// `admin,panel`, and the reverse: at most 256 characters, each a role (check_role()), none twice. Empty = none.
std::string roles_text(const std::vector<std::string>& roles);
Result<std::vector<std::string>> parse_roles(std::string_view text);

}  // namespace rubicon::trust
