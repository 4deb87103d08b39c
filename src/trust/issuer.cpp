#include "trust/issuer.h"

#include <fmt/format.h>

#include <algorithm>

#include "trust/documents.h"
#include "trust/id_ranges.h"
#include "trust/signed_text.h"

namespace rubicon::trust {

namespace {

Result<void> check_days(int days) {
  if (days >= 1 && days <= kMaxMemberDays) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("a certificate for {} days: expected 1 to {} days", days, kMaxMemberDays));
}

/// The papers of a new realm.
Result<Papers> first_papers(const Authority& authority) {
  const auto& signer = authority.realm.permissions_ca;
  auto governance = sign_text(governance_xml(), signer, authority.permissions_key);
  if (!governance) return fail(governance.error());
  auto revoked = sign_revoked({}, signer, authority.permissions_key);
  if (!revoked) return fail(revoked.error());
  Papers papers;
  papers.identity_ca.text = authority.realm.identity_ca.pem();
  papers.permissions_ca.text = signer.pem();
  papers.governance.text = std::move(*governance);
  papers.revoked.text = std::move(*revoked);
  return papers;
}

tl::unexpected<Error> has_realm_already(const std::filesystem::path& root) {
  return fail(ErrorCode::kDuplicate,
              fmt::format("{}: has a realm already: `rubicon trust dds show` shows it; to make another one, move this "
                          "folder away first",
                          root.string()));
}

}  // namespace

bool is_island_member(const tuples::Member& member) {
  return std::any_of(member.ids.begin(), member.ids.end(),
                     [](const auto& range) { return model::is_island(OwnerId{range.first}); });
}

tl::unexpected<Error> key_of_island(const std::string& name) {
  return fail(
      ErrorCode::kInvalid,
      fmt::format("{} is the member of an island: its key is for root only, not for the people of the host", name));
}

Result<Issuer> Issuer::create(const std::filesystem::path& root, const std::string& realm, WallTime now) {
  if (auto clock = check_clock(now, "a new realm"); !clock) return fail(clock.error());
  auto authority = Authority::make(realm, now);
  if (!authority) return fail(authority.error());
  TrustFolder folder(root);
  // A host that joined has no folder `ca`, and gets none.
  if (folder.has_realm()) return has_realm_already(root);
  if (auto prepared = folder.prepare(true); !prepared) return fail(prepared.error());
  auto lock = folder.files().lock();
  if (!lock) return fail(lock.error());
  if (folder.has_realm()) return has_realm_already(root);
  const auto papers = first_papers(*authority);
  if (!papers) return fail(papers.error());
  auto written = folder.write_authority(*authority);
  if (written) written = Ledger().write(folder);
  if (written) written = folder.write_realm(*papers);
  if (!written) return fail(written.error());
  return Issuer(std::move(folder), std::move(*lock), std::move(*authority), Ledger(), now);
}

Result<Issuer> Issuer::open(const std::filesystem::path& root, WallTime now) {
  TrustFolder folder(root);
  if (auto seen = folder.files().check_exists(kIdentityCaFile, {}); !seen && seen.error().code != ErrorCode::kNotFound)
    return fail(seen.error());
  if (!folder.has_realm())
    return fail(
        ErrorCode::kNotFound,
        fmt::format("{}: has no realm: `rubicon trust dds init` makes one, `rubicon trust dds join` takes part in one",
                    root.string()));
  if (auto there = folder.check_authority(); !there) return fail(there.error());
  auto lock = folder.files().lock();
  if (!lock) return fail(lock.error());
  auto authority = folder.authority(now);
  if (!authority) return fail(authority.error());
  auto ledger = Ledger::read(folder);
  if (!ledger) return fail(ledger.error());
  return Issuer(std::move(folder), std::move(*lock), std::move(*authority), std::move(*ledger), now);
}

Result<void> Issuer::check_meanings(const MemberOptions& options) const {
  for (const auto& name : folder_.members()) {
    const auto member = folder_.member(name);
    if (member && member->has_role(options.name))
      return fail(ErrorCode::kDuplicate, fmt::format("{} is a role of {}: a rule of rights that names one would mean "
                                                     "both; choose another name",
                                                     options.name, name));
    if (std::find(options.roles.begin(), options.roles.end(), name) != options.roles.end())
      return fail(ErrorCode::kDuplicate, fmt::format("{} is the name of a member: a rule of rights that names one "
                                                     "would mean both; choose another role",
                                                     name));
  }
  return {};
}

Result<RevokedList> Issuer::revoked() const {
  const auto text = folder_.files().read(kRevokedFile, kLargestSigned);
  if (!text) return fail(text.error());
  return read_revoked(*text, authority_.realm.permissions_ca, folder_.files().path(kRevokedFile));
}

Result<void> Issuer::check_island(const MemberOptions& options) const {
  if (options.island == model::kNoOwner) return {};
  if (!model::is_island(options.island))
    return fail(ErrorCode::kOutOfRange, fmt::format("{} is no id of an island: expected 1 to {}",
                                                    model::number(options.island), model::kMaxIslandId));
  const auto revoked = this->revoked();
  if (!revoked) return fail(revoked.error());
  for (const auto& name : folder_.members()) {
    const auto member = folder_.member(name);
    if (!member && !is_in_force(name, *revoked)) continue;
    if (!member)
      return fail(member.error().code,
                  fmt::format("{}; it may have the id of island {}: put the file back from your copy of the folder, or "
                              "revoke {}",
                              member.error().text, model::number(options.island), name));
    if (member->may_use(options.island) && member->expires > now_ && revoked->find(member->serial) == nullptr)
      return fail(ErrorCode::kDuplicate, fmt::format("the member {} has the id of island {}: revoke it first", name,
                                                     model::number(options.island)));
  }
  return {};
}

bool Issuer::is_in_force(const std::string& name, const RevokedList& revoked) const {
  const auto given = ledger_.of_name(name);
  return std::any_of(given.begin(), given.end(), [&](const LedgerEntry& entry) {
    return entry.ends > now_ && revoked.find(entry.serial) == nullptr;
  });
}

bool Issuer::was_cut_short(const std::string& name, const EVP_PKEY* key) const {
  const auto given = ledger_.of_name(name);
  if (given.empty() || folder_.files().exists(certificate_file(name))) return false;
  const auto pem = folder_.files().read_key(key_file(name));
  if (!pem) return false;
  const auto former = PrivateKey::of_pem(pem->view(), folder_.files().path(key_file(name)));
  const auto revoked = this->revoked();
  if (!former || !revoked || EVP_PKEY_eq(former->get(), key) != 1) return false;
  return std::none_of(given.begin(), given.end(),
                      [&](const LedgerEntry& entry) { return revoked->find(entry.serial) != nullptr; });
}

Result<void> Issuer::check(const MemberOptions& options, const EVP_PKEY* key) const {
  if (auto checked = check_member_name(options.name); !checked) return checked;
  if (ledger_.has_name(options.name) && !was_cut_short(options.name, key))
    return fail(
        ErrorCode::kDuplicate,
        fmt::format(
            "the name {} was given before: names of members are unique for ever, also those of revoked "
            "ones; `rubicon trust dds renew` gives a member a new certificate; if its key is lost, revoke it and "
            "add another name",
            options.name));
  if (auto days = check_days(options.days); !days) return days;
  if (auto roles = parse_roles(roles_text(options.roles)); !roles) return fail(roles.error());
  if (auto meanings = check_meanings(options); !meanings) return meanings;
  return check_island(options);
}

Result<Papers> Issuer::certify(const MemberOptions& options, EVP_PKEY* key) {
  if (auto checked = check(options, key); !checked) return fail(checked.error());
  tuples::Member member{options.name, options.roles, {}, {}, {}};
  if (options.island != model::kNoOwner)
    member.ids.push_back({model::number(options.island), model::number(options.island)});
  const auto block = ledger_.take_block();
  if (!block) return fail(block.error());
  member.ids.push_back(block_range(*block));
  return certify_again(member, key, options.days);
}

Result<Papers> Issuer::certify_again(const tuples::Member& member, EVP_PKEY* key, int days) {
  if (auto checked = check_days(days); !checked) return fail(checked.error());
  const auto organisation = authority_.realm.identity_ca.organisation();
  const auto papers =
      authority_.certify({organisation, member.name, member.ids, member.roles, now_ + std::chrono::days(days), key});
  if (!papers) return papers;
  const auto made = Certificate::of_pem(papers->certificate.text, "the new certificate");
  if (!made) return fail(made.error());
  // First, so that nothing is given twice whatever happens next: was_cut_short() finds what has no certificate then.
  ledger_.add({member.name, made->serial(), made->ends()});
  if (auto noted = ledger_.write(folder_); !noted) return fail(noted.error());
  if (auto written = folder_.write_member(member.name, *papers); !written) return fail(written.error());
  return folder_.papers(member.name);
}

}  // namespace rubicon::trust
