#include "trust/rights/rule.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/property_alias.h"
#include "rubicon/address.hpp"
#include "rubicon/key.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::trust::rights {

namespace {

constexpr std::string_view kWords[] = {"read", "demand", "set", "approve", "send"};
constexpr std::size_t kMaxName = 64;  // of a certificate (RFC 5280, ub-common-name)
constexpr std::uint32_t kMaxIsland = 65532;

bool is_of_parts(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

bool is_island(std::string_view text) {
  const auto id = base::parse_number<std::uint32_t>(text.substr(kIsland.size()));
  return id && *id >= 1 && *id <= kMaxIsland;
}

bool is_part(std::string_view part, bool last) {
  if (part == "**") return last;
  const auto good = [](char c) { return is_of_parts(c) || c == '*'; };
  return !part.empty() && std::all_of(part.begin(), part.end(), good) && part.find("**") == part.npos;
}

}  // namespace

std::string_view to_string(Right right) {
  return kWords[static_cast<std::size_t>(right)];
}

std::optional<Right> right_of(std::string_view word) {
  const auto* const found = std::find(std::begin(kWords), std::end(kWords), word);
  return found == std::end(kWords) ? std::nullopt : std::optional(kRights[found - std::begin(kWords)]);
}

RightSet RightSet::all() {
  RightSet set;
  for (const auto right : kRights) set.add(right);
  return set;
}

Result<void> check_who(std::string_view who) {
  const auto good = [](char c) { return is_of_parts(c) || c == '.' || c == '@'; };
  auto name = who;
  for (const auto source : {kUser, kGroup, kMember, kRole, kToken, kBridge}) {
    if (name.starts_with(source)) name.remove_prefix(source.size());
    if (name.size() < who.size()) break;
  }
  const auto longest = name.find('@') == name.npos ? kMaxName : 2 * kMaxName + 1;  // of two: who vouches stands behind
  const bool named = !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), good);
  if (who.starts_with(kIsland) ? is_island(who) : named) return {};
  return fail(
      ErrorCode::kInvalid,
      fmt::format("{}: expected the name or the role of a member, user:<name>, group:<name>, member:<name>, "
                  "role:<name>, token:<name>@<member>, bridge:<name>, everybody, lan, peis, or island:<1 to {}>",
                  model::quoted(who), kMaxIsland));
}

Result<void> check_vouched(std::string_view names) {
  const auto good = [](char c) { return is_of_parts(c) || c == '.' || c == '@' || c == ':' || c == '*'; };
  if (!names.empty() && names.size() <= tuples::kMaxAsker && std::all_of(names.begin(), names.end(), good)) return {};
  return fail(ErrorCode::kInvalid, fmt::format("{}: expected names with their source, such as user:*, member:desk or "
                                               "token:*",
                                               model::quoted(names)));
}

Result<void> check_rule_key(std::string_view pattern) {
  if (pattern.starts_with(kIsland) && is_island(pattern)) return {};
  auto rest = pattern;
  std::size_t parts = 0;
  bool good = pattern.size() <= model::kMaxKeyLength;
  for (bool last = false; good && !last; ++parts) {
    const auto dot = rest.find('.');
    last = dot == rest.npos;
    good = is_part(rest.substr(0, dot), last);
    if (!last) rest.remove_prefix(dot + 1);
  }
  if (good && parts <= model::kMaxKeyParts) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: expected parts of A-Z a-z 0-9 _ - joined by dots, with * for any text in a part and ** "
                          "for all that follow, or island:<id>",
                          model::quoted(pattern)));
}

std::string kept_key(std::string_view key) {
  constexpr auto kDotsOfProperty = 4;  // proxy.<network>.<device>.property.<name>
  return std::count(key.begin(), key.end(), '.') >= kDotsOfProperty ? model::without_alias(key) : std::string(key);
}

}  // namespace rubicon::trust::rights
