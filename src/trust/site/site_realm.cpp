#include "trust/site/site_realm.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/json_depth.h"
#include "base/printable.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "trust/member_names.h"
#include "trust/signed_text.h"
#include "trust/site/user_names.h"

namespace rubicon::trust::site {

namespace {

using Json = nlohmann::json;

constexpr int kRealmForm = 1;
constexpr const char* kRealmFormName = "rubicon-realm";
constexpr std::size_t kRealmLevels = 2;
constexpr std::size_t kLongestRealm = 64;

Result<void> check_bounds(const SiteRealm& realm) {
  const auto full = [](std::size_t most, const char* what) {
    return fail(ErrorCode::kBusy, fmt::format("the realm would have more than {} {}: make a new realm", most, what));
  };
  if (realm.members.size() > SiteRealm::kMaxMembers) return full(SiteRealm::kMaxMembers, "members");
  if (realm.islands.size() > SiteRealm::kMaxIslands) return full(SiteRealm::kMaxIslands, "islands");
  if (realm.revoked.size() > SiteRealm::kMaxRevoked) return full(SiteRealm::kMaxRevoked, "revoked names");
  return {};
}

bool read_members(const Json& json, SiteRealm& realm) {
  if (!json.is_object() || json.size() > SiteRealm::kMaxMembers) return false;
  for (const auto& [user, text] : json.items()) {
    if (!text.is_string() || !check_user_name(user)) return false;
    auto roles = parse_roles(text.get<std::string>());
    if (!roles) return false;
    realm.members.emplace(user, std::move(*roles));
  }
  return true;
}

/// Of members only: an island of somebody unknown would be nobody's. No name has a blank.
bool read_islands(const Json& json, SiteRealm& realm) {
  if (!json.is_object()) return false;
  for (const auto& [id, users] : json.items()) {
    const auto number = base::parse_number<std::uint32_t>(id);
    if (!number || !model::is_island(OwnerId{*number}) || !users.is_string()) return false;
    auto rest = std::string_view(users.get_ref<const std::string&>());
    for (auto end = rest.find(' ');; end = rest.find(' ')) {
      const auto user = rest.substr(0, end);
      if (!realm.is_member(user) || !realm.islands.emplace(*number, user).second) return false;
      if (realm.islands.size() > SiteRealm::kMaxIslands) return false;
      if (end == rest.npos) break;
      rest.remove_prefix(end + 1);
    }
  }
  return true;
}

bool read_revoked_names(const Json& json, SiteRealm& realm) {
  if (!json.is_array() || json.size() > SiteRealm::kMaxRevoked) return false;
  for (const auto& user : json) {
    if (!user.is_string() || !check_user_name(user.get<std::string>())) return false;
    if (realm.is_member(user.get<std::string>())) return false;
    if (!realm.revoked.insert(user.get<std::string>()).second) return false;
  }
  return true;
}

bool read_parts(const Json& json, SiteRealm& realm) {
  if (!json.is_object() || !json.contains(kRealmFormName) || json[kRealmFormName] != kRealmForm) return false;
  const auto number = json.find("number"), members = json.find("members"), islands = json.find("islands"),
             revoked = json.find("revoked");
  auto name = model::find_text(json, "name");
  if (!name || name->empty() || name->size() > kLongestRealm || *name != base::one_line(*name)) return false;
  if (number == json.end() || members == json.end() || islands == json.end() || revoked == json.end()) return false;
  if (!number->is_number_unsigned()) return false;
  realm.name = std::move(*name);
  realm.number = number->get<std::uint64_t>();
  return read_members(*members, realm) && read_islands(*islands, realm) && read_revoked_names(*revoked, realm);
}

}  // namespace

const SiteRealm::Roles& SiteRealm::roles_of(std::string_view user) const {
  static const Roles kNone;
  const auto found = members.find(user);
  return found == members.end() ? kNone : found->second;
}

std::vector<std::string> SiteRealm::members_of(OwnerId island) const {
  std::vector<std::string> all;
  const auto id = model::number(island);
  for (auto one = islands.lower_bound({id, {}}); one != islands.end() && one->first == id; ++one)
    all.push_back(one->second);
  return all;
}

Result<std::string> realm_text(const SiteRealm& realm) {
  if (auto bounded = check_bounds(realm); !bounded) return fail(bounded.error());
  Json members = Json::object(), islands = Json::object(), revoked = Json::array();
  for (const auto& [user, roles] : realm.members) members[user] = roles_text(roles);
  for (const auto& [id, user] : realm.islands) {
    auto& users = islands[fmt::format("{}", id)];
    users = users.is_null() ? user : users.get<std::string>() + ' ' + user;
  }
  for (const auto& user : realm.revoked) revoked.push_back(user);
  const Json json{{kRealmFormName, kRealmForm},    {"name", realm.name},
                  {"number", realm.number},        {"members", std::move(members)},
                  {"islands", std::move(islands)}, {"revoked", std::move(revoked)}};
  return model::dump(json) + "\n";
}

Result<SiteRealm> parse_realm(std::string_view json, std::string_view where) {
  const auto wrong = [&] {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is no realm file that this release knows, of at most {} members, "
                            "{} islands and {} revoked names",
                            where, SiteRealm::kMaxMembers, SiteRealm::kMaxIslands, SiteRealm::kMaxRevoked));
  };
  if (json.size() > kMaxRealm || base::is_nested_deeper(json, kRealmLevels)) return wrong();
  const auto parsed = model::parse_json(json);
  SiteRealm realm;
  if (parsed.is_discarded() || !read_parts(parsed, realm)) return wrong();
  return realm;
}

Result<std::string> sign_realm(const SiteRealm& realm, const Certificate& authority, const PrivateKey& key) {
  const auto text = realm_text(realm);
  if (!text) return text;
  auto document = sign_text(*text, authority, key);
  if (document && document->size() > kMaxRealm)
    return fail(
        ErrorCode::kBusy,
        fmt::format("the realm file would have more than {} bytes: fewer members, roles or shorter names", kMaxRealm));
  return document;
}

Result<SiteRealm> read_realm(std::string_view document, const Certificate& authority, std::string_view where) {
  if (document.size() > kMaxRealm)
    return fail(ErrorCode::kInvalid, fmt::format("{}: has more than {} bytes", where, kMaxRealm));
  const auto text = verified_text(document, authority, where);
  if (!text) return fail(text.error());
  auto realm = parse_realm(*text, where);
  if (realm && realm->name != authority.organisation())
    return fail(ErrorCode::kInvalid, fmt::format("{}: is of the realm {}, and its authority of {}", where, realm->name,
                                                 authority.organisation()));
  return realm;
}

}  // namespace rubicon::trust::site
