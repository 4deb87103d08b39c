#include <fmt/format.h>

#include <algorithm>

#include "trust/site/site_folder.h"
#include "trust/site/site_identity.h"
#include "trust/site/site_members.h"
#include "trust/site/site_operations.h"
#include "trust/site/site_proofs.h"

namespace rubicon::trust::site {

namespace {

/// A bundle that was checked, but for its key or password.
struct OpenedSiteBundle {
  SiteBundle bundle;
  Certificate authority;
  SiteRealm realm;
  std::string user;
  std::optional<Certificate> certificate;

  bool needs_phrase() const { return !bundle.key.empty() || !certificate; }
};

Result<void> check_membership(const SiteRealm& realm, const std::string& user) {
  if (realm.is_member(user)) return {};
  return fail(ErrorCode::kRefused,
              realm.is_revoked(user) ? fmt::format("the bundle: {} was revoked", user)
                                     : fmt::format("the bundle: {} is not a member of the realm {}", user, realm.name));
}

Result<OpenedSiteBundle> open_site_bundle(std::string_view text, WallTime now) {
  auto bundle = read_site_bundle(text);
  if (!bundle) return fail(bundle.error());
  auto authority = Certificate::of_pem(bundle->authority, "the bundle: authority");
  if (!authority) return fail(authority.error());
  if (auto checked = check_site_authority(*authority, now, "the bundle: authority"); !checked)
    return fail(checked.error());
  auto realm = read_realm(bundle->realm, *authority, "the bundle: realm");
  if (!realm) return fail(realm.error());
  OpenedSiteBundle opened{std::move(*bundle), std::move(*authority), std::move(*realm), {}, {}};
  opened.user = opened.bundle.user;
  if (!opened.bundle.certificate.empty()) {
    auto certificate = Certificate::of_pem(opened.bundle.certificate, "the bundle: certificate");
    if (!certificate) return fail(certificate.error());
    auto user = check_site_member(*certificate, opened.authority, now, "the bundle: certificate");
    if (!user) return fail(user.error());
    opened.user = std::move(*user);
    opened.certificate = std::move(*certificate);
  }
  if (auto member = check_membership(opened.realm, opened.user); !member) return fail(member.error());
  return opened;
}

/// The realm of the folder, if that is newer, goes into the bundle. kDuplicate: the folder has another authority.
Result<void> meet_site_folder(const SiteFolder& folder, OpenedSiteBundle& opened, WallTime now) {
  if (!folder.has_realm()) return {};
  const auto authority = folder.authority(now);
  if (!authority) return fail(authority.error());
  if (*authority != opened.authority)
    return fail(
        ErrorCode::kDuplicate,
        fmt::format("{}: has the realm {}, and the bundle is of {}: move this folder away first, or use another",
                    folder.files().path(""), authority->organisation(), opened.realm.name));
  auto present = folder.realm(*authority);
  if (!present) return fail(present.error());
  if (present->number <= opened.realm.number) return {};
  auto document = folder.realm_document();
  if (!document) return fail(document.error());
  opened.bundle.realm = std::move(*document);
  opened.realm = std::move(*present);
  return check_membership(opened.realm, opened.user);
}

/// All certificates begin on one day: of two of a member, the one that ends first is the older one.
Result<void> check_not_older_one(const SiteFolder& folder, const OpenedSiteBundle& opened) {
  if (!opened.certificate || !folder.files().exists(member_certificate(opened.user))) return {};
  const auto present = folder.certificate(opened.user);
  if (!present || opened.certificate->ends() >= present->ends()) return {};
  return fail(
      ErrorCode::kDuplicate,
      fmt::format("the bundle: its certificate of {} ends on {}, but the one in {} ends on {}: expected a newer "
                  "one; `rubicon trust join --older` takes it anyway",
                  opened.user, date_text(opened.certificate->ends()),
                  folder.files().path(member_certificate(opened.user)), date_text(present->ends())));
}

Result<PrivateKey> key_for_member(const SiteFolder& folder, const OpenedSiteBundle& opened, std::string_view phrase) {
  if (!opened.bundle.key.empty()) return PrivateKey::decrypted(opened.bundle.key, phrase, "the bundle: key");
  if (folder.has_key(opened.user)) return folder.key(opened.user);
  return fail(ErrorCode::kNotFound, fmt::format("{}: is not here, and the bundle has no key: join {} on the host "
                                                "where it joined before",
                                                folder.files().path(member_key(opened.user)), opened.user));
}

/// What only the member has, by the phrase.
struct Secret {
  std::optional<PrivateKey> key;
  SecretText password;
};

Result<Secret> secret_in(const SiteFolder& folder, const OpenedSiteBundle& opened, std::string_view phrase) {
  Secret secret;
  if (!opened.certificate) {
    secret.password = spelled_phrase(phrase);
    if (is_password_of(secret.password.view(), opened.bundle.password_hash)) return secret;
    return fail(ErrorCode::kRefused, "the bundle: the pass phrase is not the password that was shown when it was made");
  }
  auto key = key_for_member(folder, opened, phrase);
  if (!key) return fail(key.error());
  if (!opened.certificate->has_key(key->get()))
    return fail(ErrorCode::kInvalid,
                fmt::format("the bundle: the key does not belong to the certificate of {}", opened.user));
  secret.key = std::move(*key);
  return secret;
}

/// The authority last: with it the folder has a realm.
Result<void> write_joined(const SiteFolder& folder, const OpenedSiteBundle& opened, const Secret& secret,
                          KeyReaders readers) {
  const auto& user = opened.user;
  auto written = secret.key ? folder.write_key(user, *secret.key, readers)
                            : folder.write_password(user, secret.password.view(), readers);
  if (written && opened.certificate) written = folder.write_certificate(user, *opened.certificate);
  if (written) written = folder.write_realm(opened.bundle.realm);
  if (written) written = folder.write_authority(opened.authority);
  return written;
}

SiteBundleContents contents_of_bundle(const OpenedSiteBundle& opened) {
  ListedSiteMember member{opened.user, opened.realm.roles_of(opened.user), {}, {}, !opened.certificate, {}, false};
  for (const auto& [id, user] : opened.realm.islands) {
    if (user == opened.user) member.islands.push_back(OwnerId{id});
  }
  if (opened.certificate) member.ends = opened.certificate->ends();
  return {identity_of(opened.authority), std::move(member), opened.bundle.brokers, opened.needs_phrase()};
}

}  // namespace

Result<SiteBundleContents> inspect_bundle(std::string_view bundle, WallTime now) {
  const auto opened = open_site_bundle(bundle, now);
  if (!opened) return fail(opened.error());
  return contents_of_bundle(*opened);
}

Result<SiteBundleContents> join_site(const std::filesystem::path& folder, std::string_view bundle,
                                     std::string_view phrase, WallTime now, Older older, KeyReaders readers) {
  auto opened = open_site_bundle(bundle, now);
  if (!opened) return fail(opened.error());
  const SiteFolder target(folder);
  const auto secret = secret_in(target, *opened, phrase);
  if (!secret) return fail(secret.error());
  if (auto prepared = target.prepare(false); !prepared) return fail(prepared.error());
  const auto lock = target.files().lock();
  if (!lock) return fail(lock.error());
  if (auto met = meet_site_folder(target, *opened, now); !met) return fail(met.error());
  if (older == Older::kRefuse) {
    if (auto newer = check_not_older_one(target, *opened); !newer) return fail(newer.error());
  }
  const auto& name = opened->certificate ? member_key(opened->user) : member_password(opened->user);
  if (target.files().key_readers(name) == KeyReaders::kPeople) readers = KeyReaders::kPeople;
  if (auto written = write_joined(target, *opened, *secret, readers); !written) return fail(written.error());
  return contents_of_bundle(*opened);
}

}  // namespace rubicon::trust::site
