#include "trust/member_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "base/text.h"

namespace rubicon::trust {

namespace {

constexpr std::size_t kMaxNameText = 64;  // ub-common-name of RFC 5280
constexpr std::size_t kMaxRole = 32;
constexpr std::size_t kMaxRolesLength = 256;

bool is_letter_or_digit(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9');
}

bool is_word(std::string_view text, std::size_t longest) {
  if (text.empty() || text.size() > longest || !is_letter_or_digit(text.front())) return false;
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return is_letter_or_digit(c) || c == '-' || c == '_' || c == '.'; });
}

tl::unexpected<Error> not_a_word(std::string_view what, std::string_view text, std::size_t longest) {
  return fail(
      ErrorCode::kInvalid,
      fmt::format("`{}` is no {}: expected 1 to {} letters, digits, `-`, `_` and `.`, the first one a letter or "
                  "digit",
                  base::one_line(text.substr(0, longest)), what, longest));
}

/// The pieces between commas; a text without a comma is one piece.
std::vector<std::string_view> pieces_of(std::string_view text) {
  std::vector<std::string_view> pieces;
  while (true) {
    const auto comma = text.find(',');
    pieces.push_back(text.substr(0, comma));
    if (comma == text.npos) return pieces;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<void> check_member_name(std::string_view name) {
  static constexpr std::array<std::string_view, 5> kReserved{"everybody", "peis", "lan", "all", "admin"};
  if (!is_word(name, kMaxNameText)) return not_a_word("name of a member", name, kMaxNameText);
  if (std::find(kReserved.begin(), kReserved.end(), name) != kReserved.end())
    return fail(ErrorCode::kInvalid,
                fmt::format("`{}` is not a name of a member: it means something else in rights", name));
  return {};
}

Result<void> check_role(std::string_view role) {
  static constexpr std::array<std::string_view, 4> kReserved{"everybody", "peis", "lan", "all"};
  if (!is_word(role, kMaxRole)) return not_a_word("role", role, kMaxRole);
  if (std::find(kReserved.begin(), kReserved.end(), role) != kReserved.end())
    return fail(ErrorCode::kInvalid, fmt::format("`{}` is not a role: it means something else in rights", role));
  return {};
}

std::string roles_text(const std::vector<std::string>& roles) {
  return fmt::format("{}", fmt::join(roles, ","));
}

Result<std::vector<std::string>> parse_roles(std::string_view text) {
  std::vector<std::string> roles;
  if (text.empty()) return roles;
  if (text.size() > kMaxRolesLength)
    return fail(ErrorCode::kInvalid, fmt::format("has roles of more than {} characters", kMaxRolesLength));
  for (const auto role : pieces_of(text)) {
    if (auto checked = check_role(role); !checked) return fail(checked.error());
    if (std::find(roles.begin(), roles.end(), role) != roles.end())
      return fail(ErrorCode::kInvalid, fmt::format("has the role `{}` twice", role));
    roles.emplace_back(role);
  }
  return roles;
}

}  // namespace rubicon::trust
