#include "trust/trust_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "trust/place.h"
#include "trust/signed_text.h"

namespace rubicon::trust {

namespace {

constexpr mode_t kPublicFile = 0644, kKeyFile = 0600, kPeopleKeyFile = 0640;
constexpr mode_t kPublicFolder = 0755, kPrivateFolder = 0700;

std::string member_folder(const std::string& member) {
  return "members/" + member;
}

}  // namespace

std::string certificate_file(const std::string& member) {
  return member_folder(member) + "/certificate.pem";
}

std::string permissions_file(const std::string& member) {
  return member_folder(member) + "/permissions.p7s";
}

std::string key_file(const std::string& member) {
  return member_folder(member) + "/key.pem";
}

Result<Paper> TrustFolder::read(const std::string& name, std::size_t largest) const {
  auto text = files_.read(name, largest);
  if (!text) return fail(text.error());
  return Paper{std::move(*text), files_.path(name)};
}

Result<Papers> TrustFolder::realm_papers() const {
  Papers papers;
  for (auto [name, largest, paper] : {std::tuple(kIdentityCaFile, kLargestCertificate, &papers.identity_ca),
                                      std::tuple(kPermissionsCaFile, kLargestCertificate, &papers.permissions_ca),
                                      std::tuple(kGovernanceFile, kLargestSigned, &papers.governance),
                                      std::tuple(kRevokedFile, kLargestSigned, &papers.revoked)}) {
    auto read_paper = read(name, largest);
    if (!read_paper) return fail(read_paper.error());
    *paper = std::move(*read_paper);
  }
  return papers;
}

Result<Papers> TrustFolder::papers(const std::string& member) const {
  auto papers = realm_papers();
  if (!papers) return papers;
  auto certificate = read(certificate_file(member), kLargestCertificate);
  if (!certificate) return fail(certificate.error());
  auto permissions = read(permissions_file(member), kLargestSigned);
  if (!permissions) return fail(permissions.error());
  papers->certificate = std::move(*certificate);
  papers->permissions = std::move(*permissions);
  return papers;
}

Result<Authority> TrustFolder::authority(WallTime now) const {
  const auto papers = realm_papers();
  if (!papers) return fail(papers.error());
  auto realm = check_realm(*papers, now);
  if (!realm) return fail(realm.error());
  std::vector<PrivateKey> keys;
  for (const auto& [name, certificate] :
       {std::pair(kIdentityKeyFile, &realm->identity_ca), std::pair(kPermissionsKeyFile, &realm->permissions_ca)}) {
    const auto pem = files_.read_key(name, KeyReaders::kOwner);
    if (!pem) return fail(pem.error());
    auto key = PrivateKey::of_pem(pem->view(), files_.path(name));
    if (!key) return fail(key.error());
    if (!certificate->has_key(key->get()))
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: is not the key of {}", files_.path(name), certificate->subject()));
    keys.push_back(std::move(*key));
  }
  return Authority{std::move(*realm), std::move(keys[0]), std::move(keys[1])};
}

Result<void> TrustFolder::check_authority() const {
  return files_.check_exists(kIdentityKeyFile,
                             "is not here: members are added, renewed and revoked on the host that made the realm");
}

std::vector<std::string> TrustFolder::members() const {
  auto names = files_.names("members");
  std::erase_if(names, [this](const auto& name) { return !files_.exists(certificate_file(name)); });
  return names;
}

Result<Certificate> TrustFolder::certificate(const std::string& name) const {
  const auto paper = read(certificate_file(name), kLargestCertificate);
  if (!paper) return fail(paper.error());
  return Certificate::of_pem(paper->text, paper->where);
}

Result<tuples::Member> TrustFolder::member(const std::string& name) const {
  const auto read_one = certificate(name);
  if (!read_one) return fail(read_one.error());
  const auto where = files_.path(certificate_file(name));
  auto member = read_one->member(where);
  if (member && member->name != name)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is the certificate of {}: expected that of {}", where, member->name, name));
  return member;
}

Result<void> TrustFolder::prepare(bool with_authority) const {
  // What a person has; units of systemd, which have users of their own, read what root has.
  const bool is_own = files_.path("") == (user_folder() / "").string() || (!with_authority && ::geteuid() != 0);
  if (auto made = files_.make_folder("", is_own ? kPrivateFolder : kPublicFolder); !made) return made;
  if (auto made = files_.make_folder("members", kPublicFolder); !made) return made;
  return with_authority ? files_.make_folder("ca", kPrivateFolder) : Result<void>();
}

Result<void> TrustFolder::write_authority(const Authority& authority) const {
  for (const auto& [name, key] : {std::pair(kIdentityKeyFile, &authority.identity_key),
                                  std::pair(kPermissionsKeyFile, &authority.permissions_key)}) {
    const auto pem = key->pem();
    if (!pem) return fail(pem.error());
    if (auto written = files_.write(name, pem->view(), kKeyFile); !written) return written;
  }
  return {};
}

Result<void> TrustFolder::write_realm(const Papers& papers) const {
  auto written = files_.write(kGovernanceFile, papers.governance.text, kPublicFile);
  if (written) written = files_.write(kRevokedFile, papers.revoked.text, kPublicFile);
  if (written) written = files_.write(kPermissionsCaFile, papers.permissions_ca.text, kPublicFile);
  if (written) written = files_.write(kIdentityCaFile, papers.identity_ca.text, kPublicFile);
  return written;
}

Result<void> TrustFolder::write_revoked(std::string_view document) const {
  return files_.write(kRevokedFile, document, kPublicFile);
}

Result<void> TrustFolder::write_key(const std::string& member, const PrivateKey& key, KeyReaders readers) const {
  const auto pem = key.pem();
  if (!pem) return fail(pem.error());
  if (auto made = files_.make_folder(member_folder(member), kPublicFolder); !made) return made;
  const bool is_for_people = readers == KeyReaders::kPeople || member == kLocalMember;
  const auto group = is_for_people && ::geteuid() == 0 ? people_group() : std::nullopt;
  return files_.write(key_file(member), pem->view(), group ? kPeopleKeyFile : kKeyFile, group);
}

Result<void> TrustFolder::write_member(const std::string& member, const Papers& papers) const {
  auto written = files_.make_folder(member_folder(member), kPublicFolder);
  if (written) written = files_.write(permissions_file(member), papers.permissions.text, kPublicFile);
  if (written) written = files_.write(certificate_file(member), papers.certificate.text, kPublicFile);
  return written;
}

}  // namespace rubicon::trust
