#include <fmt/format.h>

#include "trust/bundle.h"
#include "trust/certificate_request.h"
#include "trust/fingerprint.h"
#include "trust/issuer.h"
#include "trust/operations.h"
#include "trust/place.h"

namespace rubicon::trust {

namespace {

constexpr const char* kRequest = "the request";

/// That of an earlier try which did not come to its end, else a new one.
Result<PrivateKey> key_of(const TrustFolder& folder, const std::string& name) {
  if (auto checked = check_member_name(name); !checked) return fail(checked.error());
  const auto& files = folder.files();
  if (!files.exists(key_file(name)) || files.exists(certificate_file(name))) return PrivateKey::make();
  const auto pem = files.read_key(key_file(name));
  if (!pem) return fail(pem.error());
  return PrivateKey::of_pem(pem->view(), files.path(key_file(name)));
}

Result<tuples::Member> add_member_here(Issuer& issuer, const MemberOptions& options, KeyReaders readers) {
  const auto key = key_of(issuer.folder(), options.name);
  if (!key) return fail(key.error());
  // The key first: a member without its key could not be made again, because its name is taken.
  if (auto checked = issuer.check(options, key->get()); !checked) return fail(checked.error());
  if (auto written = issuer.folder().write_key(options.name, *key, readers); !written) return fail(written.error());
  const auto papers = issuer.certify(options, key->get());
  if (!papers) return fail(papers.error());
  return issuer.folder().member(options.name);
}

}  // namespace

MemberOptions member_of_people() {
  return {kLocalMember, {}, {"admin"}, kMemberDays};
}

MemberOptions member_of_island(OwnerId island) {
  return {fmt::format("island-{}", model::number(island)), island, {}, kMemberDays};
}

Result<RealmIdentity> init(const std::filesystem::path& folder, const InitOptions& options, WallTime now) {
  auto issuer = Issuer::create(folder, options.realm, now);
  if (!issuer) return fail(issuer.error());
  if (auto added = add_member_here(*issuer, member_of_people(), KeyReaders::kPeople); !added)
    return fail(added.error());
  for (const auto island : options.islands) {
    if (auto added = add_member_here(*issuer, member_of_island(island), KeyReaders::kOwner); !added)
      return fail(added.error());
  }
  return issuer->authority().realm.identity();
}

Result<tuples::Member> add_here(const std::filesystem::path& folder, const MemberOptions& options, WallTime now,
                                KeyReaders readers) {
  if (options.island != model::kNoOwner && readers == KeyReaders::kPeople) return key_of_island(options.name);
  auto issuer = Issuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  return add_member_here(*issuer, options, readers);
}

Result<Issued> add(const std::filesystem::path& folder, const MemberOptions& options, WallTime now) {
  auto issuer = Issuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  const auto key = PrivateKey::make();
  if (!key) return fail(key.error());
  auto phrase = new_phrase();
  if (!phrase) return fail(phrase.error());
  auto encrypted = key->encrypted(phrase->view());
  if (!encrypted) return fail(encrypted.error());
  auto papers = issuer->certify(options, key->get());
  if (!papers) return fail(papers.error());
  auto member = issuer->folder().member(options.name);
  if (!member) return fail(member.error());
  return Issued{std::move(*member), issuer->authority().realm.identity(),
                bundle_text({std::move(*papers), std::move(*encrypted)}), std::move(*phrase)};
}

Result<std::string> key_fingerprint(std::string_view request) {
  const auto asked = CertificateRequest::of_pem(request, kRequest);
  if (!asked) return fail(asked.error());
  return fingerprint_of(asked->key());
}

Result<Issued> sign(const std::filesystem::path& folder, std::string_view request, const MemberOptions& options,
                    WallTime now) {
  const auto asked = CertificateRequest::of_pem(request, kRequest);
  if (!asked) return fail(asked.error());
  auto issuer = Issuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  auto order = options;
  if (order.name.empty()) order.name = asked->name();
  if (order.name != asked->name())
    return fail(ErrorCode::kInvalid,
                fmt::format("the request is that of {}: expected that of {}", asked->name(), order.name));
  auto papers = issuer->certify(order, asked->key());
  if (!papers) return fail(papers.error());
  auto member = issuer->folder().member(order.name);
  if (!member) return fail(member.error());
  return Issued{std::move(*member), issuer->authority().realm.identity(), bundle_text({std::move(*papers), {}}), {}};
}

}  // namespace rubicon::trust
