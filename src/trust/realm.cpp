#include "trust/realm.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>

#include "base/printable.h"
#include "trust/certificate_parts.h"
#include "trust/documents.h"
#include "trust/fingerprint.h"
#include "trust/id_ranges.h"
#include "trust/signed_text.h"

namespace rubicon::trust {

namespace {

constexpr std::size_t kLongestRealmName = 40;

Result<void> check_realm_name(std::string_view name) {
  const bool good = !name.empty() && name.size() <= kLongestRealmName && name.front() != ' ' && name.back() != ' ' &&
                    std::all_of(name.begin(), name.end(), [](char c) {
                      return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == ' ' ||
                             c == '-' || c == '_' || c == '.';
                    });
  if (good) return {};
  return fail(ErrorCode::kInvalid, fmt::format("`{}` is no name of a realm: expected 1 to {} letters, digits, blanks, "
                                               "`-`, `_` and `.`, no blank at the ends",
                                               base::one_line(name.substr(0, kLongestRealmName)), kLongestRealmName));
}

Result<Certificate> read_authority(const Paper& paper, AuthorityKind kind, WallTime now) {
  auto certificate = Certificate::of_pem(paper.text, paper.where);
  if (!certificate) return certificate;
  if (auto checked = check_authority(*certificate, kind, now, paper.where); !checked) return fail(checked.error());
  return certificate;
}

Result<void> check_governance(const Paper& governance, const Realm& realm) {
  const auto text = verified_text(governance.text, realm.permissions_ca, governance.where);
  if (!text) return fail(text.error());
  if (text->find("<domain_access_rules>") != text->npos) return {};
  return fail(ErrorCode::kInvalid, fmt::format("{}: is signed, but is no governance", governance.where));
}

}  // namespace

RealmIdentity Realm::identity() const {
  return {identity_ca.organisation(), fingerprint_of(der_of(identity_ca) + der_of(permissions_ca))};
}

Result<Realm> check_realm(const Papers& papers, WallTime now) {
  auto identities = read_authority(papers.identity_ca, AuthorityKind::kIdentities, now);
  if (!identities) return fail(identities.error());
  auto permissions = read_authority(papers.permissions_ca, AuthorityKind::kPermissions, now);
  if (!permissions) return fail(permissions.error());
  Realm realm{std::move(*identities), std::move(*permissions)};
  if (realm.identity_ca.organisation() != realm.permissions_ca.organisation())
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: the authority of another realm ({}) than {} ({})", papers.permissions_ca.where,
                            realm.permissions_ca.subject(), papers.identity_ca.where, realm.identity_ca.subject()));
  if (realm.permissions_ca.has_key(X509_get0_pubkey(realm.identity_ca.get())))
    return fail(ErrorCode::kInvalid, fmt::format("{}: has the key of {}: expected two different keys",
                                                 papers.permissions_ca.where, papers.identity_ca.where));
  if (auto governed = check_governance(papers.governance, realm); !governed) return fail(governed.error());
  return realm;
}

Result<CheckedPapers> check_papers(const Papers& papers, WallTime now) {
  auto realm = check_realm(papers, now);
  if (!realm) return fail(realm.error());
  auto revoked = read_revoked(papers.revoked.text, realm->permissions_ca, papers.revoked.where);
  if (!revoked) return fail(revoked.error());
  auto certificate = Certificate::of_pem(papers.certificate.text, papers.certificate.where);
  if (!certificate) return fail(certificate.error());
  if (auto issued = check_issued(*certificate, realm->identity_ca, now, papers.certificate.where); !issued)
    return fail(issued.error());
  auto member = certificate->member(papers.certificate.where);
  if (!member) return fail(member.error());
  const auto xml = verified_text(papers.permissions.text, realm->permissions_ca, papers.permissions.where);
  if (!xml) return fail(xml.error());
  if (auto allowed = check_permissions(*xml, *certificate, now, papers.permissions.where); !allowed)
    return fail(allowed.error());
  return CheckedPapers{std::move(*realm), std::move(*revoked), std::move(*certificate), std::move(*member)};
}

Result<std::string> new_realm_name(const std::string& name) {
  if (auto checked = check_realm_name(name); !checked) return fail(checked.error());
  std::array<unsigned char, 2> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return openssl_failed("name a realm");
  return fmt::format("{} {:02x}{:02x}", name, random[0], random[1]);
}

Result<Authority> Authority::make(const std::string& name, WallTime now) {
  const auto named = new_realm_name(name);
  if (!named) return fail(named.error());
  const auto& realm = *named;
  auto identity_key = PrivateKey::make(), permissions_key = PrivateKey::make();
  if (!identity_key) return fail(identity_key.error());
  if (!permissions_key) return fail(permissions_key.error());
  const auto ends = now + std::chrono::days(kRealmDays);
  auto identities = make_authority(AuthorityKind::kIdentities, realm, ends, *identity_key);
  if (!identities) return fail(identities.error());
  auto permissions = make_authority(AuthorityKind::kPermissions, realm, ends, *permissions_key);
  if (!permissions) return fail(permissions.error());
  return Authority{
      {std::move(*identities), std::move(*permissions)}, std::move(*identity_key), std::move(*permissions_key)};
}

Result<Papers> Authority::certify(const CertificateOrder& order) const {
  auto certificate = issue(order, realm.identity_ca, identity_key);
  if (!certificate) return fail(certificate.error());
  const auto member = certificate->member("the new certificate");
  if (!member) return fail(member.error());
  const auto xml = permissions_xml(*member, certificate->subject());
  if (!xml) return fail(xml.error());
  auto permissions = sign_text(*xml, realm.permissions_ca, permissions_key);
  if (!permissions) return fail(permissions.error());
  Papers papers;
  papers.certificate.text = certificate->pem();
  papers.permissions.text = std::move(*permissions);
  return papers;
}

}  // namespace rubicon::trust
