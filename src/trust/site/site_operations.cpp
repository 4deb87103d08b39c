#include "trust/site/site_operations.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "trust/member_names.h"
#include "trust/site/brokers.h"
#include "trust/site/site_identity.h"
#include "trust/site/site_issuer.h"
#include "trust/site/site_members.h"

namespace rubicon::trust::site {

/// All files of a broker, with a certificate for its hosts. Its key stays if there is one.
Result<void> write_broker(const SiteIssuer& issuer, const BrokerFolder& broker);
/// What changes with members: access list, revocation list, passwords. In each folder of the realm.
std::vector<BrokerUpdate> update_brokers(const SiteIssuer& issuer);

namespace {

constexpr mode_t kBrokerFolderMode = 0755, kStateMode = 0700;
constexpr mode_t kOpenMode = 0644, kBrokerSecretMode = 0640;
constexpr std::size_t kMaxPasswordFile = 4UL << 20U;
constexpr int kBrokerDays = 3650;

/// Files that the broker alone reads belong to its user: newer releases of mosquitto refuse others.
class BrokerFiles {
 public:
  explicit BrokerFiles(const MosquittoSetup& setup) : files_(setup.folder) {
    const auto user = ::geteuid() == 0 && !setup.user.empty() ? service_user(setup.user) : std::nullopt;
    if (!user) return;
    owner_ = user->user;
    group_ = user->group;
  }

  const FolderFiles& files() const { return files_; }
  Result<void> write(const char* name, std::string_view text) const { return files_.write(name, text, kOpenMode); }
  Result<void> write_secret(const char* name, std::string_view text) const {
    return files_.write(name, text, kBrokerSecretMode, group_, owner_);
  }
  /// For the database, where no unit makes it.
  Result<void> make_state(const std::string& state) const {
    if (std::error_code error; std::filesystem::is_directory(state, error)) return {};
    if (auto made = FolderFiles(state).make_folder("", kStateMode); !made) return made;
    if (!owner_ || ::chown(state.c_str(), *owner_, *group_) == 0) return {};
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be given to the user of the broker", state));
  }

 private:
  FolderFiles files_;
  std::optional<uid_t> owner_;
  std::optional<gid_t> group_;
};

Result<PrivateKey> key_of_broker(const FolderFiles& files) {
  if (!files.exists(kBrokerKeyFile)) return PrivateKey::make();
  auto pem = files.read(kBrokerKeyFile, 4096);
  if (!pem) return fail(pem.error());
  const SecretText secret(std::move(*pem));
  return PrivateKey::of_pem(secret.view(), files.path(kBrokerKeyFile));
}

/// Users of mosquitto_passwd stay, but for those who were shut out.
Result<void> write_passwords(const BrokerFiles& broker, const SiteIssuer& issuer) {
  PasswordLines lines;
  if (broker.files().exists(kBrokerPasswordsFile)) {
    const auto text = broker.files().read(kBrokerPasswordsFile, kMaxPasswordFile);
    if (!text) return fail(text.error());
    auto read = parse_passwords(*text, broker.files().path(kBrokerPasswordsFile));
    if (!read) return fail(read.error());
    lines = std::move(*read);
  }
  std::erase_if(lines, [&](const auto& one) { return issuer.realm.is_revoked(one.first); });
  for (const auto& [user, hash] : issuer.passwords) lines[user] = hash;
  return broker.write_secret(kBrokerPasswordsFile, passwords_text(lines));
}

Result<void> write_members(const BrokerFiles& broker, const MosquittoSetup& setup, const SiteIssuer& issuer) {
  const auto list = issuer.revocation();
  if (!list) return fail(list.error());
  auto written = broker.write(kBrokerRevocationFile, *list);
  if (written) written = broker.write_secret(kAclFile, mosquitto_acl(issuer.realm.revoked));
  if (written && setup.takes_passwords) written = write_passwords(broker, issuer);
  return written;
}

Result<void> write_certificate_of(const BrokerFiles& broker, const SiteIssuer& issuer) {
  const auto key = key_of_broker(broker.files());
  if (!key) return fail(key.error());
  const auto pem = key->pem();
  if (!pem) return fail(pem.error());
  const auto certificate =
      issue_broker(issuer.brokers.names(), {"broker", issuer.now() + std::chrono::days(kBrokerDays), key->get()},
                   issuer.authority(), issuer.key());
  if (!certificate) return fail(certificate.error());
  auto written = broker.write_secret(kBrokerKeyFile, pem->view());
  if (written) written = broker.write(kBrokerCertificateFile, certificate->pem());
  if (written) written = broker.write(kBrokerAuthorityFile, issuer.authority().pem());
  return written;
}

}  // namespace

Result<void> write_broker(const SiteIssuer& issuer, const BrokerFolder& broker) {
  const auto& setup = broker.setup;
  const BrokerFiles files(setup);
  auto written = files.files().make_folder("", kBrokerFolderMode);
  if (written) written = files.files().make_folder(kBrokerMoreFolder, kBrokerFolderMode);
  if (written && broker.unit.empty()) written = files.make_state(setup.state);
  if (written) written = write_certificate_of(files, issuer);
  if (written) written = write_members(files, setup, issuer);
  if (written) written = files.write(kMosquittoFile, mosquitto_conf(setup));
  return written;
}

std::vector<BrokerUpdate> update_brokers(const SiteIssuer& issuer) {
  std::vector<BrokerUpdate> updates;
  for (const auto& one : issuer.brokers.folders) {
    const auto written = write_members(BrokerFiles(one.setup), one.setup, issuer);
    updates.push_back({one, written ? std::nullopt : std::optional(written.error())});
  }
  return updates;
}

namespace {

/// A word of rights must not mean a member and a role.
Result<void> check_words(const SiteRealm& realm, const std::string& name, const std::vector<std::string>& roles) {
  for (const auto& [user, held] : realm.members) {
    if (std::find(held.begin(), held.end(), name) != held.end())
      return fail(ErrorCode::kDuplicate, fmt::format("{} is a role of {}: a rule of rights that names one would mean "
                                                     "both; choose another name",
                                                     name, user));
  }
  for (const auto& role : roles) {
    if (role != name && !realm.is_member(role)) continue;
    return fail(ErrorCode::kDuplicate, fmt::format("{} is the name of a member: a rule of rights that names one would "
                                                   "mean both; choose another role",
                                                   role));
  }
  return {};
}

Result<void> check_islands(const std::string& name, const std::vector<OwnerId>& islands) {
  for (const auto island : islands) {
    const auto id = model::number(island);
    if (!model::is_island(island))
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("{} is not an id of an island: expected 1 to {}", id, model::kMaxIslandId));
  }
  return check_island_of(name, islands);
}

Result<void> check_standing(const SiteRealm& realm, const std::string& name, const std::vector<std::string>& roles,
                            const std::vector<OwnerId>& islands) {
  if (auto parsed = parse_roles(roles_text(roles)); !parsed) return fail(parsed.error());
  if (auto checked = check_words(realm, name, roles); !checked) return checked;
  return check_islands(name, islands);
}

Result<void> check_new(const SiteIssuer& issuer, const SiteMemberOptions& options) {
  if (auto checked = check_user_name(options.name); !checked) return checked;
  if (options.days < 1 || options.days > kMaxMemberDays)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a certificate for {} days: expected 1 to {} days", options.days, kMaxMemberDays));
  if (issuer.realm.is_member(options.name))
    return fail(ErrorCode::kDuplicate,
                fmt::format("{} is a member already: `rubicon trust change` gives it other roles or islands, `rubicon "
                            "trust renew` a new certificate, with --new-key also a new key",
                            options.name));
  if (issuer.ledger.has_name(options.name))
    return fail(ErrorCode::kDuplicate,
                fmt::format("the name {} was used before: names of members, also of revoked ones, are unique for "
                            "ever and without regard to case; choose another name",
                            options.name));
  return check_standing(issuer.realm, options.name, options.roles, options.islands);
}

void set_standing(SiteRealm& realm, const std::string& name, const std::vector<std::string>& roles,
                  const std::vector<OwnerId>& islands) {
  realm.members[name] = roles;
  std::erase_if(realm.islands, [&](const auto& one) { return one.second == name; });
  for (const auto island : islands) realm.islands.emplace(model::number(island), name);
}

/// The bundle for another host; the certificate is in the folder too, so that it can be renewed.
Result<SiteIssued> issue_bundle(SiteIssuer& issuer, const std::string& name, int days) {
  const auto key = PrivateKey::make();
  if (!key) return fail(key.error());
  auto phrase = new_phrase();
  if (!phrase) return fail(phrase.error());
  auto encrypted = key->encrypted(phrase->view());
  if (!encrypted) return fail(encrypted.error());
  const auto certificate = issuer.certify(name, key->get(), days);
  if (!certificate) return fail(certificate.error());
  if (auto saved = issuer.save(); !saved) return fail(saved.error());
  if (auto written = issuer.folder().write_certificate(name, *certificate); !written) return fail(written.error());
  const SiteBundle bundle{
      issuer.authority().pem(),       issuer.document(), certificate->pem(), std::move(*encrypted), {}, {},
      issuer.brokers.addresses(false)};
  return SiteIssued{listed_member(issuer.folder(), issuer.realm, name), identity_of(issuer.authority()),
                    bundle_text(bundle), std::move(*phrase)};
}

/// For the key that was certified before.
Result<SiteIssued> certify_former_key(SiteIssuer& issuer, const std::string& name, int days) {
  const auto former = issuer.folder().certificate(name);
  if (!former) return fail(former.error());
  const auto certificate = issuer.certify(name, X509_get0_pubkey(former->get()), days);
  if (!certificate) return fail(certificate.error());
  if (auto written = issuer.folder().write_certificate(name, *certificate); !written) return fail(written.error());
  SiteIssued issued{
      listed_member(issuer.folder(), issuer.realm, name), identity_of(issuer.authority()), {}, SecretText()};
  if (issued.member.has_key) return issued;
  issued.bundle = bundle_text(
      {issuer.authority().pem(), issuer.document(), certificate->pem(), {}, {}, {}, issuer.brokers.addresses(false)});
  return issued;
}

tl::unexpected<Error> no_site_member(const std::string& name) {
  return fail(ErrorCode::kNotFound, fmt::format("no member {}: `rubicon trust show` shows all", name));
}

Result<void> check_brokers(const std::vector<std::string>& brokers) {
  for (const auto& one : brokers) {
    if (auto checked = check_broker(one); !checked) return checked;
  }
  return {};
}

/// Makes room in a full list: a name whose certificates ended cannot be proven any more.
void drop_ended_names(SiteIssuer& issuer) {
  if (issuer.realm.revoked.size() < SiteRealm::kMaxRevoked) return;
  std::erase_if(issuer.realm.revoked, [&](const auto& user) { return issuer.ledger.has_ended(user, issuer.now()); });
}

}  // namespace

Result<RealmIdentity> init(const std::filesystem::path& folder, const SiteInit& options, WallTime now) {
  if (auto checked = check_brokers(options.brokers); !checked) return fail(checked.error());
  auto issuer = SiteIssuer::create(folder, options.realm, now);
  if (!issuer) return fail(issuer.error());
  issuer->brokers.hosts = options.brokers;
  if (auto saved = issuer->save_brokers(); !saved) return fail(saved.error());
  return identity_of(issuer->authority());
}

Result<SiteIssued> add(const std::filesystem::path& folder, const SiteMemberOptions& options, WallTime now) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (auto checked = check_new(*issuer, options); !checked) return fail(checked.error());
  set_standing(issuer->realm, options.name, options.roles, options.islands);
  return issue_bundle(*issuer, options.name, options.days);
}

Result<ListedSiteMember> add_here(const std::filesystem::path& folder, const SiteMemberOptions& options, WallTime now,
                                  KeyReaders readers) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (auto checked = check_new(*issuer, options); !checked) return fail(checked.error());
  set_standing(issuer->realm, options.name, options.roles, options.islands);
  const auto key = PrivateKey::make();
  if (!key) return fail(key.error());
  const auto certificate = issuer->certify(options.name, key->get(), options.days);
  if (!certificate) return fail(certificate.error());
  auto written = issuer->folder().write_key(options.name, *key, readers);
  if (written) written = issuer->folder().write_certificate(options.name, *certificate);
  if (written) written = issuer->save();
  if (!written) return fail(written.error());
  return listed_member(issuer->folder(), issuer->realm, options.name);
}

Result<AddedPassword> add_with_password(const std::filesystem::path& folder, const SiteMemberOptions& options,
                                        WallTime now) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (auto checked = check_new(*issuer, options); !checked) return fail(checked.error());
  set_standing(issuer->realm, options.name, options.roles, options.islands);
  auto phrase = new_phrase();
  if (!phrase) return fail(phrase.error());
  auto hash = password_hash(phrase->view());
  if (!hash) return fail(hash.error());
  issuer->ledger.add({options.name, {}, {}, {}});
  issuer->passwords[options.name] = *hash;
  if (auto saved = issuer->save(); !saved) return fail(saved.error());
  const SiteBundle bundle{issuer->authority().pem(),      issuer->document(), {}, {}, options.name, std::move(*hash),
                          issuer->brokers.addresses(true)};
  auto member = listed_member(issuer->folder(), issuer->realm, options.name);
  member.has_password = true;
  SiteIssued issued{std::move(member), identity_of(issuer->authority()), bundle_text(bundle), std::move(*phrase)};
  return AddedPassword{std::move(issued), update_brokers(*issuer)};
}

Result<Renewed> renew(const std::filesystem::path& folder, const std::string& name, int days, RenewKey key,
                      WallTime now) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (issuer->realm.is_revoked(name))
    return fail(ErrorCode::kRefused,
                fmt::format("{} was revoked: `rubicon trust add` certifies it under another name", name));
  if (!issuer->realm.is_member(name)) return no_site_member(name);
  if (issuer->passwords.contains(name))
    return fail(ErrorCode::kUnsupported, fmt::format("{} has a password, which does not end", name));
  if (days < 1 || days > kMaxMemberDays)
    return fail(ErrorCode::kOutOfRange, fmt::format("{} days: expected 1 to {} days", days, kMaxMemberDays));
  if (key == RenewKey::kKeep) {
    auto issued = certify_former_key(*issuer, name, days);
    if (!issued) return fail(issued.error());
    return Renewed{std::move(*issued), {}};
  }
  if (issuer->folder().has_key(name))
    return fail(ErrorCode::kUnsupported,
                fmt::format("the key of {} is on this host ({}): remove it first, if it is lost or known to others",
                            name, issuer->folder().files().path(member_key(name))));
  issuer->ledger.revoke(name, now);
  auto issued = issue_bundle(*issuer, name, days);
  if (!issued) return fail(issued.error());
  return Renewed{std::move(*issued), update_brokers(*issuer)};
}

Result<ListedSiteMember> change(const std::filesystem::path& folder, const std::string& name,
                                const std::optional<std::vector<std::string>>& roles,
                                const std::optional<std::vector<OwnerId>>& islands, WallTime now) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  if (!issuer->realm.is_member(name)) return no_site_member(name);
  const auto before = listed_member(issuer->folder(), issuer->realm, name);
  const auto& new_roles = roles ? *roles : before.roles;
  const auto& new_islands = islands ? *islands : before.islands;
  if (auto checked = check_standing(issuer->realm, name, new_roles, new_islands); !checked)
    return fail(checked.error());
  set_standing(issuer->realm, name, new_roles, new_islands);
  if (auto saved = issuer->save(); !saved) return fail(saved.error());
  return listed_member(issuer->folder(), issuer->realm, name);
}

Result<std::vector<BrokerUpdate>> revoke(const std::filesystem::path& folder, const std::string& name, WallTime now) {
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  // Again, if the first try did not come to its end.
  if (!issuer->realm.is_member(name) && !issuer->realm.is_revoked(name)) return no_site_member(name);
  drop_ended_names(*issuer);
  issuer->ledger.revoke(name, now);
  issuer->passwords.erase(name);
  set_standing(issuer->realm, name, {}, {});
  issuer->realm.members.erase(name);
  issuer->realm.revoked.insert(name);
  if (auto saved = issuer->save(); !saved) return fail(saved.error());
  return update_brokers(*issuer);
}

Result<BrokerFolder> set_up_mosquitto(const std::filesystem::path& folder, const BrokerFolder& broker,
                                      const std::vector<std::string>& hosts, WallTime now) {
  if (auto checked = check_brokers(hosts); !checked) return fail(checked.error());
  auto issuer = SiteIssuer::open(folder, now);
  if (!issuer) return fail(issuer.error());
  auto& list = issuer->brokers;
  if (!hosts.empty()) list.hosts = hosts;
  if (list.hosts.empty())
    return fail(ErrorCode::kInvalid, "how do members reach this broker? expected --broker HOST, its name or address");
  if (auto* known = list.find(broker.setup.folder); known != nullptr) {
    *known = broker;
  } else {
    list.folders.push_back(broker);
  }
  if (auto saved = issuer->save_brokers(); !saved) return fail(saved.error());
  if (auto written = write_broker(*issuer, broker); !written) return fail(written.error());
  return broker;
}

}  // namespace rubicon::trust::site
