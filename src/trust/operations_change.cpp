#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "trust/bundle.h"
#include "trust/issuer.h"
#include "trust/operations.h"
#include "trust/place.h"
#include "trust/signed_text.h"

namespace rubicon::trust {

namespace {

Result<RevokedList> revoked_in(const TrustFolder& folder, const Realm& realm) {
  const auto text = folder.files().read(kRevokedFile, kLargestSigned);
  if (!text) return fail(text.error());
  return read_revoked(*text, realm.permissions_ca, folder.files().path(kRevokedFile));
}

tl::unexpected<Error> no_member(const std::string& name) {
  return fail(ErrorCode::kNotFound, fmt::format("no member {}: `rubicon trust dds show` shows all", name));
}

/// Makes room in a list that is full: certificates that ended count no more anyway.
void drop_ended(RevokedList& list, const Ledger& ledger, WallTime now) {
  if (list.certificates.size() <= RevokedList::kMost) return;
  std::erase_if(list.certificates, [&](const RevokedCertificate& one) {
    const auto entries = ledger.of_name(one.name);
    return std::any_of(entries.begin(), entries.end(),
                       [&](const LedgerEntry& entry) { return entry.serial == one.serial && entry.ends < now; });
  });
}

int days_until(WallTime end, WallTime now) {
  return static_cast<int>(std::chrono::floor<std::chrono::days>(end - now).count());
}

/// An authority that was restored from an older copy must not use a number again that the lost one gave: others would
/// not take its list. The lost one never used a second that is still to come.
std::uint64_t next_number(std::uint64_t number, WallTime now) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now.time_since_epoch()).count();
  return std::max(number + 1, static_cast<std::uint64_t>(std::max<std::int64_t>(seconds, 0)));
}

/// A folder whose authority ended must still be shown.
WallTime within_life(const Papers& papers, WallTime now) {
  const auto authority = Certificate::of_pem(papers.identity_ca.text, papers.identity_ca.where);
  if (!authority) return now;
  return std::clamp(now, authority->begins(),
                    std::max(authority->begins(), authority->ends() - std::chrono::seconds(1)));
}

}  // namespace

Result<bool> give_local_to_people(const std::filesystem::path& folder) {
  const TrustFolder changed(folder);
  const auto& files = changed.files();
  const auto name = key_file(kLocalMember);
  if (::geteuid() != 0 || !people_group() || !files.exists(name) || files.key_readers(name) == KeyReaders::kPeople)
    return false;
  const auto lock = files.lock();
  if (!lock) return fail(lock.error());
  const auto pem = files.read_key(name, KeyReaders::kOwner);
  if (!pem) return fail(pem.error());
  const auto key = PrivateKey::of_pem(pem->view(), files.path(name));
  if (!key) return fail(key.error());
  if (auto written = changed.write_key(kLocalMember, *key, KeyReaders::kPeople); !written) return fail(written.error());
  return true;
}

Result<std::string> revoke(const std::filesystem::path& folder, const std::string& name, WallTime now) {
  const auto issuer = Issuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  const auto& authority = issuer->authority();
  auto list = revoked_in(issuer->folder(), authority.realm);
  if (!list) return fail(list.error());
  const auto given = issuer->ledger().of_name(name);
  if (given.empty()) return no_member(name);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  const auto before = list->certificates.size();
  for (const auto& entry : given) {
    if (list->find(entry.serial) == nullptr) list->certificates.push_back({entry.serial, name, seconds});
  }
  if (list->certificates.size() != before) list->number = next_number(list->number, now);
  drop_ended(*list, issuer->ledger(), now);
  auto document = sign_revoked(*list, authority.realm.permissions_ca, authority.permissions_key);
  if (!document) return document;
  if (auto written = issuer->folder().write_revoked(*document); !written) return fail(written.error());
  return document;
}

Result<Issued> renew(const std::filesystem::path& folder, const std::string& name, int days, WallTime now) {
  auto issuer = Issuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (issuer->ledger().of_name(name).empty()) return no_member(name);
  const auto revoked = revoked_in(issuer->folder(), issuer->authority().realm);
  if (!revoked) return fail(revoked.error());
  const auto former = issuer->folder().certificate(name);
  if (!former) return fail(former.error());
  const auto member = issuer->folder().member(name);
  if (!member) return fail(member.error());
  if (revoked->find(member->serial) != nullptr)
    return fail(ErrorCode::kRefused,
                fmt::format("{} was revoked: `rubicon trust dds add` certifies it under another name", name));
  auto papers = issuer->certify_again(*member, X509_get0_pubkey(former->get()), days);
  if (!papers) return fail(papers.error());
  auto renewed = issuer->folder().member(name);
  if (!renewed) return fail(renewed.error());
  return Issued{std::move(*renewed), issuer->authority().realm.identity(), bundle_text({std::move(*papers), {}}), {}};
}

Result<FolderContents> show(const std::filesystem::path& folder, WallTime now) {
  const TrustFolder shown(folder);
  const auto papers = shown.realm_papers();
  if (!papers) return fail(papers.error());
  const auto realm = check_realm(*papers, within_life(*papers, now));
  if (!realm) return fail(realm.error());
  const auto revoked = read_revoked(papers->revoked.text, realm->permissions_ca, papers->revoked.where);
  if (!revoked) return fail(revoked.error());
  FolderContents contents{
      realm->identity(), shown.has_authority(), days_until(realm->identity_ca.ends(), now), revoked->number, {}, {}};
  for (const auto& name : shown.members()) {
    auto member = shown.member(name);
    if (!member) {
      contents.unreadable.push_back({name, member.error().text, revoked->has_name(name)});
      continue;
    }
    const auto* gone = revoked->find(member->serial);
    const int days = days_until(member->expires, now);
    contents.members.push_back({std::move(*member), days, shown.files().exists(key_file(name)),
                                gone == nullptr ? std::nullopt : std::optional(gone->when)});
  }
  return contents;
}

Result<Issued> export_member(const std::filesystem::path& folder, const std::string& name, WallTime now) {
  if (auto checked = check_member_name(name); !checked) return fail(checked.error());
  const TrustFolder from(folder);
  if (from.has_realm() && !from.files().exists(certificate_file(name))) return no_member(name);
  auto papers = from.papers(name);
  if (!papers) return fail(papers.error());
  auto checked = check_papers(*papers, now);
  if (!checked) return fail(checked.error());
  Issued issued{std::move(checked->member), checked->realm.identity(), {}, {}};
  std::string encrypted;
  if (from.files().exists(key_file(name))) {
    const auto pem = from.files().read_key(key_file(name));
    if (!pem) return fail(pem.error());
    const auto key = PrivateKey::of_pem(pem->view(), from.files().path(key_file(name)));
    if (!key) return fail(key.error());
    auto phrase = new_phrase();
    if (!phrase) return fail(phrase.error());
    auto text = key->encrypted(phrase->view());
    if (!text) return fail(text.error());
    encrypted = std::move(*text);
    issued.phrase = std::move(*phrase);
  }
  issued.bundle = bundle_text({std::move(*papers), std::move(encrypted)});
  return issued;
}

}  // namespace rubicon::trust
