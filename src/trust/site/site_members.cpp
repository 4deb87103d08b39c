#include "trust/site/site_members.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "trust/site/site_issuer.h"

namespace rubicon::trust::site {

namespace {

constexpr int kSiteForm = 2, kDdsForm = 1;
constexpr const char* kSiteFormName = "rubicon-trust";
constexpr std::string_view kProtectedKey = "-----BEGIN ENCRYPTED PRIVATE KEY-----\n";
constexpr std::size_t kMaxBrokers = 16;
constexpr std::uint16_t kTlsPort = 8883;

/// The parts by their names in the file, the brokers besides.
constexpr std::array<std::pair<const char*, std::string SiteBundle::*>, 6> kParts{
    {{"authority", &SiteBundle::authority},
     {"realm", &SiteBundle::realm},
     {"certificate", &SiteBundle::certificate},
     {"key", &SiteBundle::key},
     {"user", &SiteBundle::user},
     {"password", &SiteBundle::password_hash}}};
constexpr const char* kBrokers = "brokers";

tl::unexpected<Error> no_site_bundle(std::string_view why) {
  return fail(ErrorCode::kInvalid, fmt::format("the bundle: {}: expected a file of `rubicon trust add`", why));
}

Result<std::vector<std::string>> brokers_in(std::string_view text) {
  std::vector<std::string> brokers;
  while (!text.empty()) {
    const auto end = text.find(' ');
    const auto one = text.substr(0, end);
    const auto address = base::parse_host_port(one, kTlsPort);
    if (!address || address->host.empty() || brokers.size() == kMaxBrokers)
      return no_site_bundle("has brokers that are no addresses");
    brokers.emplace_back(one);
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
  }
  return brokers;
}

Result<void> check_parts(const SiteBundle& bundle) {
  if (bundle.authority.empty() || bundle.realm.empty()) return no_site_bundle("has no authority, or no realm");
  const bool has_password = !bundle.user.empty() && !bundle.password_hash.empty();
  if (bundle.certificate.empty() != has_password || (has_password && !bundle.key.empty()))
    return no_site_bundle("has neither a certificate nor a user with a password, or both");
  if (!bundle.key.empty() && !bundle.key.starts_with(kProtectedKey))
    return no_site_bundle("has a key that no pass phrase protects");
  return {};
}

}  // namespace

std::string bundle_text(const SiteBundle& bundle) {
  std::string text = fmt::format("{{\"{}\": {}", kSiteFormName, kSiteForm);
  const auto add = [&text](const char* name, std::string_view content) {
    if (content.empty()) return;
    text += fmt::format(",\n \"{}\": ", name);
    model::append_json(content, text);
  };
  for (const auto& [name, part] : kParts) add(name, bundle.*part);
  add(kBrokers, fmt::format("{}", fmt::join(bundle.brokers, " ")));
  return text + "}\n";
}

Result<SiteBundle> read_site_bundle(std::string_view text) {
  if (text.size() > kMaxSiteBundle) return no_site_bundle(fmt::format("has more than {} bytes", kMaxSiteBundle));
  if (base::is_nested_deeper(text, 1)) return no_site_bundle("is no JSON object of texts");
  const auto json = model::parse_json(text);
  if (!json.is_object() || !json.contains(kSiteFormName)) return no_site_bundle("is no JSON object of texts");
  if (json[kSiteFormName] == kDdsForm)
    return fail(
        ErrorCode::kInvalid,
        "the bundle: is of the certificates for DDS of an earlier release, expected one of `rubicon trust add`");
  if (json[kSiteFormName] != kSiteForm) return no_site_bundle("has a form that this release does not know");
  SiteBundle bundle;
  std::size_t known = 1;
  for (const auto& [name, part] : kParts) {
    auto content = model::find_text(json, name);
    if (!content) continue;
    bundle.*part = std::move(*content);
    ++known;
  }
  if (const auto listed = model::find_text(json, kBrokers)) {
    auto brokers = brokers_in(*listed);
    if (!brokers) return fail(brokers.error());
    bundle.brokers = std::move(*brokers);
    ++known;
  }
  if (json.size() != known) return no_site_bundle("has parts that this release does not know");
  if (auto checked = check_parts(bundle); !checked) return fail(checked.error());
  return bundle;
}

namespace {

int days_to(WallTime end, WallTime now) {
  return static_cast<int>(std::chrono::floor<std::chrono::days>(end - now).count());
}

/// `now`, moved into the life of the authority: a folder whose authority ended must still be shown.
WallTime within_life_of(const SiteFolder& folder, WallTime now) {
  const auto pem = folder.files().read(kAuthorityFile, kMaxCertificate);
  const auto authority = pem ? Certificate::of_pem(*pem, kAuthorityFile) : fail(pem.error());
  if (!authority || authority->ends() <= authority->begins()) return now;
  return std::clamp(now, authority->begins(), authority->ends() - std::chrono::seconds(1));
}

}  // namespace

ListedSiteMember listed_member(const SiteFolder& folder, const SiteRealm& realm, const std::string& name) {
  ListedSiteMember listed{name, realm.roles_of(name), {}, {}, false, {}, false};
  std::set<std::string> also;
  for (const auto& [id, user] : realm.islands) {
    if (user != name) continue;
    listed.islands.push_back(OwnerId{id});
    for (const auto& other : realm.members_of(OwnerId{id})) also.insert(other);
  }
  also.erase(name);
  listed.also.assign(also.begin(), also.end());
  if (const auto certificate = folder.certificate(name)) listed.ends = certificate->ends();
  listed.has_password = folder.files().exists(member_password(name));
  listed.has_key = folder.has_key(name) || listed.has_password;
  return listed;
}

Result<SiteContents> contents_of(const std::filesystem::path& folder, WallTime now) {
  const SiteFolder shown(folder);
  const auto authority = shown.authority(within_life_of(shown, now));
  if (!authority) return fail(authority.error());
  const auto realm = shown.realm(*authority);
  if (!realm) return fail(realm.error());
  SiteContents contents;
  contents.realm = identity_of(*authority);
  contents.has_authority = shown.has_authority();
  contents.authority_days_left = days_to(authority->ends(), now);
  contents.number = realm->number;
  contents.revoked.assign(realm->revoked.begin(), realm->revoked.end());
  for (const auto& [user, roles] : realm->members) contents.members.push_back(listed_member(shown, *realm, user));
  if (const auto brokers = BrokerList::read(shown)) {
    contents.hosts = brokers->hosts;
    contents.brokers = brokers->folders;
  }
  if (const auto ledger = SiteLedger::read(shown)) {
    for (auto& one : contents.members) {
      for (const auto& entry : ledger->entries())
        one.has_password = one.has_password || (entry.user == one.name && !entry.has_certificate());
    }
  }
  return contents;
}

}  // namespace rubicon::trust::site
