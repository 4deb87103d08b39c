#include "trust/site/site_folder.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "trust/certificate.h"
#include "trust/site/site_certificates.h"
#include "trust/site/site_place.h"
#include "trust/site/user_names.h"

namespace rubicon::trust::site {

namespace {

constexpr mode_t kForAll = 0644, kForOwner = 0600, kForPeople = 0640;
constexpr mode_t kOpenFolder = 0755, kClosedFolder = 0700;
constexpr std::size_t kLargestKeyFile = 4096;
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
  const auto pem = files_.read(kAuthorityFile, kLargestCertificate);
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
  const auto pem = files_.read(member_certificate(user), kLargestCertificate);
  if (!pem) return fail(pem.error());
  return Certificate::of_pem(*pem, files_.path(member_certificate(user)));
}

Result<PrivateKey> SiteFolder::key(const std::string& user) const {
  auto pem = files_.read(member_key(user), kLargestKeyFile);
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
