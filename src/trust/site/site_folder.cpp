#include "trust/site/site_folder.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "trust/certificate.h"
#include "trust/member_names.h"
#include "trust/site/site_identity.h"
#include "trust/site/site_proofs.h"

namespace rubicon::trust::site {

namespace {

using Json = nlohmann::json;

constexpr int kRealmForm = 1;
constexpr const char* kRealmFormName = "rubicon-realm";
constexpr std::size_t kRealmLevels = 2;
constexpr std::size_t kMaxRealmLength = 64;

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

/// Only of members: the island of an unknown user would belong to no member. No name has a blank.
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
  if (!name || name->empty() || name->size() > kMaxRealmLength || *name != base::one_line(*name)) return false;
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
                fmt::format("{}: is not a realm file that this release knows, of at most {} members, "
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

namespace {

constexpr mode_t kForAll = 0644, kForOwner = 0600, kForPeople = 0640;
constexpr mode_t kOpenFolder = 0755, kClosedFolder = 0700;
constexpr std::size_t kMaxKeyFile = 4096;
constexpr const char* kService = "rubicon";

/// SHA-256 as people compare it. Empty: OpenSSL failed.
std::string fingerprint_of(std::string_view bytes) {
  std::array<unsigned char, 32> digest{};
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1) return {};
  std::string text;
  for (std::size_t i = 0; i < digest.size(); ++i)
    text += fmt::format("{}{:02X}", i > 0 && i % 2 == 0 ? " " : "", digest[i]);
  return text;
}

std::string folder_of_member(const std::string& user) {
  return "members/" + user;
}

}  // namespace

std::string member_certificate(const std::string& user) {
  return folder_of_member(user) + "/certificate.pem";
}

std::string member_key(const std::string& user) {
  return folder_of_member(user) + "/key.pem";
}

std::string member_password(const std::string& user) {
  return folder_of_member(user) + "/password";
}

std::optional<ServiceUser> service_user(const std::string& name) {
  std::array<char, 16384> texts{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found) != 0 || found == nullptr) return {};
  return ServiceUser{entry.pw_uid, entry.pw_gid};
}

Result<void> SiteFolder::check_realm() const {
  if (auto seen = files_.check_exists(kAuthorityFile, {}); !seen && seen.error().code != ErrorCode::kNotFound)
    return seen;
  if (has_realm()) return {};
  return fail(ErrorCode::kNotFound,
              fmt::format("{}: has no realm: `rubicon trust init` makes one, `rubicon trust join` takes part in one",
                          files_.path("")));
}

Result<Certificate> SiteFolder::authority(WallTime now) const {
  if (auto there = check_realm(); !there) return fail(there.error());
  const auto pem = files_.read(kAuthorityFile, kMaxCertificate);
  if (!pem) return fail(pem.error());
  auto certificate = Certificate::of_pem(*pem, files_.path(kAuthorityFile));
  if (!certificate) return certificate;
  if (auto checked = check_site_authority(*certificate, now, files_.path(kAuthorityFile)); !checked)
    return fail(checked.error());
  return certificate;
}

Result<std::string> SiteFolder::realm_document() const {
  return files_.read(kRealmFile, kMaxRealm);
}

Result<SiteRealm> SiteFolder::realm(const Certificate& authority) const {
  const auto document = realm_document();
  if (!document) return fail(document.error());
  return read_realm(*document, authority, files_.path(kRealmFile));
}

std::vector<std::string> SiteFolder::members() const {
  auto names = files_.names("members");
  std::erase_if(names, [this](const auto& name) {
    return !check_user_name(name) ||
           (!files_.exists(member_certificate(name)) && !files_.exists(member_password(name)));
  });
  return names;
}

Result<Certificate> SiteFolder::certificate(const std::string& user) const {
  const auto pem = files_.read(member_certificate(user), kMaxCertificate);
  if (!pem) return fail(pem.error());
  return Certificate::of_pem(*pem, files_.path(member_certificate(user)));
}

Result<PrivateKey> SiteFolder::key(const std::string& user) const {
  auto pem = files_.read(member_key(user), kMaxKeyFile);
  if (!pem) return fail(pem.error());
  const SecretText secret(std::move(*pem));
  return PrivateKey::of_pem(secret.view(), files_.path(member_key(user)));
}

Result<void> SiteFolder::prepare(bool with_authority) const {
  // Services have users of their own, and read what root has.
  const bool is_own = files_.path("") == (own_site_folder() / "").string() || (!with_authority && ::geteuid() != 0);
  if (auto made = files_.make_folder("", is_own ? kClosedFolder : kOpenFolder); !made) return made;
  if (auto made = files_.make_folder("members", kOpenFolder); !made) return made;
  return with_authority ? files_.make_folder("ca", kClosedFolder) : Result<void>();
}

Result<void> SiteFolder::write_authority(const Certificate& authority) const {
  return files_.write(kAuthorityFile, authority.pem(), kForAll);
}

Result<void> SiteFolder::write_realm(std::string_view document) const {
  return files_.write(kRealmFile, document, kForAll);
}

Result<void> SiteFolder::write_certificate(const std::string& user, const Certificate& certificate) const {
  if (auto made = files_.make_folder(folder_of_member(user), kOpenFolder); !made) return made;
  return files_.write(member_certificate(user), certificate.pem(), kForAll);
}

Result<void> SiteFolder::write_key(const std::string& user, const PrivateKey& key, KeyReaders readers) const {
  const auto pem = key.pem();
  if (!pem) return fail(pem.error());
  return write_secret(user, member_key(user), pem->view(), readers);
}

Result<void> SiteFolder::write_password(const std::string& user, std::string_view password, KeyReaders readers) const {
  const SecretText line(std::string(password) + "\n");
  return write_secret(user, member_password(user), line.view(), readers);
}

Result<void> SiteFolder::write_secret(const std::string& user, const std::string& name, std::string_view text,
                                      KeyReaders readers) const {
  if (auto made = files_.make_folder(folder_of_member(user), kOpenFolder); !made) return made;
  const auto service = ::geteuid() == 0 ? service_user(kService) : std::nullopt;
  const auto people = ::geteuid() == 0 && readers == KeyReaders::kPeople ? people_group() : std::nullopt;
  std::optional<gid_t> group = people;
  std::optional<uid_t> owner;
  if (service) owner = service->user;
  if (service && !group) group = service->group;
  return files_.write(name, text, people ? kForPeople : kForOwner, group, owner);
}

RealmIdentity identity_of(const Certificate& authority) {
  return {authority.organisation(), fingerprint_of(der_of(authority))};
}

}  // namespace rubicon::trust::site
