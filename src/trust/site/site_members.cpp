#include "trust/site/site_members.h"

#include "trust/site/site_issuer.h"

namespace rubicon::trust::site {

namespace {

int days_to(WallTime end, WallTime now) {
  return static_cast<int>(std::chrono::floor<std::chrono::days>(end - now).count());
}

/// A folder whose authority ended must still be shown.
WallTime within_life_of(const SiteFolder& folder, WallTime now) {
  const auto pem = folder.files().read(kAuthorityFile, kLargestCertificate);
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
