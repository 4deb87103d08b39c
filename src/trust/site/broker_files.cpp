#include "trust/site/broker_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include "trust/site/mosquitto_setup.h"

namespace rubicon::trust::site {

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

}  // namespace rubicon::trust::site
