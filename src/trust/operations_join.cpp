#include <fmt/format.h>

#include "trust/bundle.h"
#include "trust/certificate_request.h"
#include "trust/issuer.h"
#include "trust/operations.h"

namespace rubicon::trust {

namespace {

/// A bundle that was checked, but for its key.
struct OpenedBundle {
  Bundle bundle;
  CheckedPapers checked;

  BundleContents contents() const { return {checked.realm.identity(), checked.member, !bundle.key.empty()}; }
};

Result<void> check_not_revoked(const RevokedList& revoked, const tuples::Member& member, std::string_view where) {
  const auto* found = revoked.find(member.serial);
  if (found == nullptr) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("{}: the certificate of {} was revoked on {}", where, member.name, date_text(found->when)));
}

Result<OpenedBundle> open_bundle(std::string_view text, WallTime now) {
  auto bundle = read_bundle(text);
  if (!bundle) return fail(bundle.error());
  auto checked = check_papers(bundle->papers, now);
  if (!checked) return fail(checked.error());
  if (auto good = check_not_revoked(checked->revoked, checked->member, "the bundle"); !good) return fail(good.error());
  return OpenedBundle{std::move(*bundle), std::move(*checked)};
}

/// The list of the folder, if that is newer, goes into the papers. kDuplicate: the folder has another realm.
Result<void> meet_folder(const TrustFolder& folder, OpenedBundle& opened, WallTime now) {
  if (!folder.has_realm()) return {};
  auto papers = folder.realm_papers();
  if (!papers) return fail(papers.error());
  const auto realm = check_realm(*papers, now);
  if (!realm) return fail(realm.error());
  if (*realm != opened.checked.realm)
    return fail(
        ErrorCode::kDuplicate,
        fmt::format("{}: has the realm {}, and the bundle is of {}: move this folder away first, or use another",
                    folder.files().path(""), realm->identity().name, opened.checked.realm.identity().name));
  const auto revoked = read_revoked(papers->revoked.text, realm->permissions_ca, papers->revoked.where);
  if (!revoked) return fail(revoked.error());
  if (revoked->number <= opened.checked.revoked.number) return {};
  opened.bundle.papers.revoked = std::move(papers->revoked);
  return check_not_revoked(*revoked, opened.checked.member, "the bundle");
}

/// All certificates begin on one day: of two of a member, the one that ends first is the older one.
Result<void> check_not_older(const TrustFolder& folder, const Certificate& offered, const std::string& name) {
  if (!folder.files().exists(certificate_file(name))) return {};
  const auto present = folder.certificate(name);
  if (!present || offered.ends() >= present->ends()) return {};
  return fail(
      ErrorCode::kDuplicate,
      fmt::format("the bundle: its certificate of {} ends on {}, but that in {} ends on {}: expected a newer one; "
                  "`rubicon trust dds join --older` takes it all the same",
                  name, date_text(offered.ends()), folder.files().path(certificate_file(name)),
                  date_text(present->ends())));
}

/// The key of the bundle, else that of the folder.
Result<PrivateKey> key_for(const TrustFolder& folder, const OpenedBundle& opened, std::string_view phrase) {
  const auto& name = opened.checked.member.name;
  if (!opened.bundle.key.empty()) return PrivateKey::decrypted(opened.bundle.key, phrase, "the bundle: key");
  if (!folder.files().exists(key_file(name)))
    return fail(ErrorCode::kNotFound, fmt::format("{}: is not here, and the bundle has no key: expected that of "
                                                  "`rubicon trust dds request {}`, on the host where it was run",
                                                  folder.files().path(key_file(name)), name));
  const auto pem = folder.files().read_key(key_file(name));
  if (!pem) return fail(pem.error());
  return PrivateKey::of_pem(pem->view(), folder.files().path(key_file(name)));
}

}  // namespace

Result<BundleContents> inspect(std::string_view bundle, WallTime now) {
  const auto opened = open_bundle(bundle, now);
  if (!opened) return fail(opened.error());
  return opened->contents();
}

Result<BundleContents> join(const std::filesystem::path& folder, std::string_view bundle, std::string_view phrase,
                            WallTime now, Older older, KeyReaders readers) {
  auto opened = open_bundle(bundle, now);
  if (!opened) return fail(opened.error());
  const TrustFolder target(folder);
  const auto& name = opened->checked.member.name;
  const bool is_island = is_island_member(opened->checked.member);
  if (is_island && readers == KeyReaders::kPeople) return key_of_island(name);
  const auto key = key_for(target, *opened, phrase);
  if (!key) return fail(key.error());
  if (!opened->checked.certificate.has_key(key->get()))
    return fail(ErrorCode::kInvalid, fmt::format("the bundle: the key is not that of the certificate of {}", name));
  if (auto prepared = target.prepare(false); !prepared) return fail(prepared.error());
  const auto lock = target.files().lock();
  if (!lock) return fail(lock.error());
  if (auto met = meet_folder(target, *opened, now); !met) return fail(met.error());
  if (older == Older::kRefuse) {
    if (auto newer = check_not_older(target, opened->checked.certificate, name); !newer) return fail(newer.error());
  }
  if (target.files().key_readers(key_file(name)) == KeyReaders::kPeople && !is_island) readers = KeyReaders::kPeople;
  auto written = target.write_key(name, *key, readers);
  if (written) written = target.write_member(name, opened->bundle.papers);
  if (written) written = target.write_realm(opened->bundle.papers);
  if (!written) return fail(written.error());
  return opened->contents();
}

Result<std::string> request(const std::filesystem::path& folder, const std::string& name) {
  if (auto checked = check_member_name(name); !checked) return fail(checked.error());
  const TrustFolder target(folder);
  if (auto prepared = target.prepare(false); !prepared) return fail(prepared.error());
  const auto lock = target.files().lock();
  if (!lock) return fail(lock.error());
  const auto& files = target.files();
  if (files.exists(key_file(name))) {
    const auto pem = files.read_key(key_file(name));
    if (!pem) return fail(pem.error());
    const auto key = PrivateKey::of_pem(pem->view(), files.path(key_file(name)));
    if (!key) return fail(key.error());
    return CertificateRequest::make(name, *key);
  }
  const auto key = PrivateKey::make();
  if (!key) return fail(key.error());
  if (auto written = target.write_key(name, *key, KeyReaders::kOwner); !written) return fail(written.error());
  return CertificateRequest::make(name, *key);
}

}  // namespace rubicon::trust
