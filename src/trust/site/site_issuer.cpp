#include "trust/site/site_issuer.h"

#include <fmt/format.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "trust/site/site_identity.h"

namespace rubicon::trust::site {

namespace {

constexpr const char* kEntriesFile = "ca/certificates";
constexpr std::size_t kMaxEntriesSize = 16UL << 20U;
constexpr mode_t kEntriesMode = 0600;
constexpr std::int64_t kLastSecond = 253402300799;  // 9999-12-31
constexpr std::string_view kNothing = "-";

char in_lower_case(char c) {
  return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_same_user(std::string_view left, std::string_view right) {
  return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                    [](char a, char b) { return in_lower_case(a) == in_lower_case(b); });
}

std::int64_t in_seconds(WallTime time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

std::optional<WallTime> time_in(std::string_view text) {
  const auto seconds = base::parse_number<std::int64_t>(text);
  if (!seconds || *seconds < 0 || *seconds > kLastSecond) return {};
  return WallTime(std::chrono::seconds(*seconds));
}

/// `desk 5A.. 1893456000 -`, `ann - 0 1767225600`: user, serial number, end, when it was revoked.
std::optional<SiteEntry> entry_in(std::string_view line) {
  std::array<std::string_view, 4> words;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto end = line.find(' ');
    if ((end == line.npos) != (i + 1 == words.size())) return {};
    words[i] = line.substr(0, end);
    if (end != line.npos) line.remove_prefix(end + 1);
  }
  const auto [user, serial, ends, revoked] = words;
  const bool no_serial = serial == kNothing;
  if (!check_user_name(user) || serial.empty() ||
      (!no_serial && serial.find_first_not_of("0123456789ABCDEF") != serial.npos))
    return {};
  const auto end = time_in(ends), when = revoked == kNothing ? std::nullopt : time_in(revoked);
  if (!end || (revoked != kNothing && !when)) return {};
  return SiteEntry{std::string(user), no_serial ? std::string() : std::string(serial), *end, when};
}

}  // namespace

Result<SiteLedger> SiteLedger::read(const SiteFolder& folder) {
  const auto& files = folder.files();
  const auto text = files.read(kEntriesFile, kMaxEntriesSize);
  if (!text) return fail(text.error());
  SiteLedger ledger;
  std::string_view rest = *text;
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const auto end = rest.find('\n');
    auto entry = entry_in(rest.substr(0, end));
    if (!entry || end == rest.npos)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: expected a name, the serial number of its certificate, its end and when it was "
                              "revoked, in seconds after 1970",
                              files.path(kEntriesFile), line));
    ledger.entries_.push_back(std::move(*entry));
    rest.remove_prefix(end + 1);
  }
  return ledger;
}

Result<void> SiteLedger::write(const SiteFolder& folder) const {
  std::string text;
  for (const auto& one : entries_)
    text += fmt::format("{} {} {} {}\n", one.user, one.has_certificate() ? one.serial : kNothing, in_seconds(one.ends),
                        one.revoked ? fmt::format("{}", in_seconds(*one.revoked)) : kNothing);
  return folder.files().write(kEntriesFile, text, kEntriesMode);
}

bool SiteLedger::has_name(std::string_view user) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const auto& one) { return is_same_user(one.user, user); });
}

void SiteLedger::revoke(std::string_view user, WallTime when) {
  for (auto& one : entries_) {
    if (one.user == user && !one.revoked) one.revoked = std::chrono::floor<std::chrono::seconds>(when);
  }
}

std::vector<RevokedSerial> SiteLedger::revoked(WallTime now) const {
  std::vector<RevokedSerial> all;
  for (const auto& one : entries_) {
    if (one.has_certificate() && one.revoked && !one.has_ended(now)) all.push_back({one.serial, *one.revoked});
  }
  return all;
}

bool SiteLedger::has_ended(std::string_view user, WallTime now) const {
  return std::all_of(entries_.begin(), entries_.end(),
                     [&](const auto& one) { return one.user != user || one.has_ended(now); });
}

namespace {

constexpr mode_t kSecretMode = 0600, kPublicMode = 0644;
constexpr const char* kPasswordsFile = "ca/passwords";
constexpr std::size_t kMaxPasswords = 1UL << 20U;

constexpr int kRealmDays = 7305;  // 20 years
constexpr std::size_t kMaxRealmName = 40;

Result<void> check_realm_name(std::string_view name) {
  const bool good = !name.empty() && name.size() <= kMaxRealmName && name.front() != ' ' && name.back() != ' ' &&
                    std::all_of(name.begin(), name.end(), [](char c) {
                      return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == ' ' ||
                             c == '-' || c == '_' || c == '.';
                    });
  if (good) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("`{}` is not a name of a realm: expected 1 to {} letters, digits, blanks, "
                          "`-`, `_` and `.`, no blank at the ends",
                          base::one_line(name.substr(0, kMaxRealmName)), kMaxRealmName));
}

/// With a random end: `Rubicon 5f1c`.
Result<std::string> new_realm_name(const std::string& name) {
  if (auto checked = check_realm_name(name); !checked) return fail(checked.error());
  std::array<unsigned char, 2> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return openssl_failed("name a realm");
  return fmt::format("{} {:02x}{:02x}", name, random[0], random[1]);
}

tl::unexpected<Error> has_site_realm(const SiteFolder& folder) {
  return fail(ErrorCode::kDuplicate,
              fmt::format("{}: has a realm already: `rubicon trust show` shows it; to make another one, move this "
                          "folder away first",
                          folder.files().path("")));
}

/// An authority that was restored from an older copy must not use a number again that the lost one gave: others would
/// not take its realm. The lost one never used a second that is still to come.
std::uint64_t number_after(std::uint64_t number, WallTime now) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now.time_since_epoch()).count();
  return std::max(number + 1, static_cast<std::uint64_t>(std::max<std::int64_t>(seconds, 0)));
}

Result<PrivateKey> read_authority_key(const SiteFolder& folder, const Certificate& authority) {
  const auto pem = folder.files().read_key(kAuthorityKeyFile, KeyReaders::kOwner);
  if (!pem) return fail(pem.error());
  const auto where = folder.files().path(kAuthorityKeyFile);
  auto key = PrivateKey::of_pem(pem->view(), where);
  if (key && !authority.has_key(key->get()))
    return fail(ErrorCode::kInvalid, fmt::format("{}: is not the key of {}", where, authority.subject()));
  return key;
}

}  // namespace

Result<SiteIssuer> SiteIssuer::create(const std::filesystem::path& root, const std::string& realm, WallTime now) {
  if (auto clock = check_clock(now, "a new realm"); !clock) return fail(clock.error());
  const auto name = new_realm_name(realm);
  if (!name) return fail(name.error());
  SiteFolder folder(root);
  if (folder.has_realm()) return has_site_realm(folder);
  auto key = PrivateKey::make();
  if (!key) return fail(key.error());
  auto authority = make_site_authority(*name, now + std::chrono::days(kRealmDays), *key);
  if (!authority) return fail(authority.error());
  if (auto prepared = folder.prepare(true); !prepared) return fail(prepared.error());
  auto lock = folder.files().lock();
  if (!lock) return fail(lock.error());
  if (folder.has_realm()) return has_site_realm(folder);
  const auto pem = key->pem();
  if (!pem) return fail(pem.error());
  if (auto written = folder.files().write(kAuthorityKeyFile, pem->view(), kSecretMode); !written)
    return fail(written.error());
  SiteIssuer issuer(std::move(folder), std::move(*lock), std::move(*authority), std::move(*key), now);
  issuer.realm.name = *name;
  if (auto saved = issuer.save(); !saved) return fail(saved.error());
  if (auto saved = issuer.save_brokers(); !saved) return fail(saved.error());
  // Last: with it the folder has a realm.
  if (auto written = issuer.folder_.write_authority(issuer.authority_); !written) return fail(written.error());
  return issuer;
}

Result<SiteIssuer> SiteIssuer::open(const std::filesystem::path& root, WallTime now) {
  SiteFolder folder(root);
  auto authority = folder.authority(now);
  if (!authority) return fail(authority.error());
  constexpr auto kElsewhere = "is not here: members are added, renewed and revoked on the host that made the realm";
  if (auto there = folder.files().check_exists(kAuthorityKeyFile, kElsewhere); !there) return fail(there.error());
  auto lock = folder.files().lock();
  if (!lock) return fail(lock.error());
  auto key = read_authority_key(folder, *authority);
  if (!key) return fail(key.error());
  SiteIssuer issuer(std::move(folder), std::move(*lock), std::move(*authority), std::move(*key), now);
  if (auto complete = issuer.read(); !complete) return fail(complete.error());
  return issuer;
}

Result<void> SiteIssuer::read() {
  auto document = folder_.realm_document();
  if (!document) return fail(document.error());
  auto read = read_realm(*document, authority_, folder_.files().path(kRealmFile));
  if (!read) return fail(read.error());
  auto entries = SiteLedger::read(folder_);
  if (!entries) return fail(entries.error());
  const auto text = folder_.files().read(kPasswordsFile, kMaxPasswords);
  if (!text) return fail(text.error());
  auto lines = parse_passwords(*text, folder_.files().path(kPasswordsFile));
  if (!lines) return fail(lines.error());
  auto listed = BrokerList::read(folder_);
  if (!listed) return fail(listed.error());
  document_ = std::move(*document);
  realm = std::move(*read);
  ledger = std::move(*entries);
  passwords = std::move(*lines);
  brokers = std::move(*listed);
  return {};
}

Result<Certificate> SiteIssuer::certify(const std::string& user, EVP_PKEY* key, int days) {
  auto made = issue_member({user, now_ + std::chrono::days(days), key}, authority_, key_);
  if (!made) return made;
  // First, so that it can be revoked whatever happens next.
  ledger.add({user, made->serial(), made->ends(), {}});
  if (auto noted = save_ledger(); !noted) return fail(noted.error());
  return made;
}

Result<void> SiteIssuer::save() {
  if (auto written = ledger.write(folder_); !written) return written;
  const auto& files = folder_.files();
  if (auto written = files.write(kPasswordsFile, passwords_text(passwords), kSecretMode); !written) return written;
  realm.number = number_after(realm.number, now_);
  auto document = sign_realm(realm, authority_, key_);
  if (!document) return fail(document.error());
  if (auto written = folder_.write_realm(*document); !written) return written;
  document_ = std::move(*document);
  const auto list = revocation();
  if (!list) return fail(list.error());
  return files.write(kRevocationFile, *list, kPublicMode);
}

Result<std::string> SiteIssuer::revocation() const {
  return revocation_list(ledger.revoked(now_), realm.number, authority_, key_, now_);
}

}  // namespace rubicon::trust::site
