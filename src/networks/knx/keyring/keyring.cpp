#include "networks/knx/keyring/keyring.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/bytes.h"
#include "base/text.h"
#include "model/findings.h"

namespace rubicon::networks::knx::keyring {

namespace {

constexpr std::string_view kSalt = "1.keyring.ets.knx.org";
/// ETS 5.7 pads to multiples of 32, other writers to multiples of 16.
constexpr std::size_t kRandomBytes = 8, kMaxPadding = 32;

/// Length without the padding: n bytes of value n. 0 = wrong padding, or nothing but that.
std::size_t unpadded(ByteView bytes) {
  if (bytes.empty()) return 0;
  const std::size_t padding = bytes.back();
  if (padding < 1 || padding > kMaxPadding || padding >= bytes.size()) return 0;
  const auto tail = bytes.last(padding);
  const bool good = std::all_of(tail.begin(), tail.end(), [&](auto byte) { return byte == padding; });
  return good ? bytes.size() - padding : 0;
}

}  // namespace

Result<Cipher> Cipher::make(const secure::Secret& password, std::string_view created) {
  auto key = secure::key_of_password(password.view(), kSalt);
  if (!key) return fail(key.error());
  return of_key(std::move(*key), created);
}

Result<Cipher> Cipher::of_key(secure::Key key, std::string_view created) {
  const auto digest = secure::sha256(base::as_bytes(created));
  if (!digest) return fail(digest.error());
  secure::Block start{};
  std::copy_n(digest->begin(), start.size(), start.begin());
  return Cipher(std::move(key), start);
}

Result<secure::Key> Cipher::key(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return fail(content.error());
  return secure::Key::from(content->view());
}

std::size_t Cipher::padding(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return 0;
  const auto size = unpadded(content->view());
  return size == 0 ? 0 : content->view().size() - size;
}

Result<secure::Secret> Cipher::password(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return fail(content.error());
  const auto size = unpadded(content->view());
  if (size < kRandomBytes) return fail(ErrorCode::kInvalid, "a password does not decrypt");
  const auto text = content->view().first(size).subspan(kRandomBytes);
  if (!base::is_utf8(base::as_text(text))) return fail(ErrorCode::kInvalid, "a password does not decrypt");
  return secure::Secret(text);
}

Result<secure::Block> Cipher::sign(ByteView signed_bytes) const {
  auto key_text = base::to_base64(base::as_text(key_.view()));
  Bytes all(signed_bytes.begin(), signed_bytes.end());
  all.reserve(all.size() + 1 + key_text.size());  // no copy with the key is left behind
  all.push_back(static_cast<std::uint8_t>(key_text.size()));
  all.insert(all.end(), key_text.begin(), key_text.end());
  const auto digest = secure::sha256(all);
  secure::wipe(all);
  secure::wipe(key_text);
  if (!digest) return fail(digest.error());
  secure::Block out{};
  std::copy_n(digest->begin(), out.size(), out.begin());
  return out;
}

Result<bool> Cipher::signed_by_this(const KeyringFile& file) const {
  const auto expected = sign(file.signed_bytes);
  if (!expected) return fail(expected.error());
  return secure::equal(*expected, file.signature);
}

namespace {

namespace findings = model::findings;

constexpr auto kChanged =
    "the keyring was changed after ETS exported it (its signature does not fit, although the password does): export it "
    "again";
constexpr auto kWrongPassword = "the password of the keyring is wrong";
constexpr auto kEither =
    "the password of the keyring is wrong, or the keyring was changed after ETS exported it: it holds no password that "
    "could show which";

constexpr std::size_t kBlock = 16;

/// Whether the password is right although the signature does not fit: it decrypts the stored passwords. A wrong one
/// makes garbage of them. Of one block that is text by chance in 1 of 10,000 cases, of several practically never. After
/// a change of `Created` only the first block is garbage: the padding in the last one still fits.
class Evidence {
 public:
  void add(const Bytes& encrypted, const Cipher& cipher) {
    if (encrypted.empty()) return;
    const bool is_text = cipher.password(encrypted).has_value();
    if (encrypted.size() == kBlock) {
      ++short_;
      if (is_text) ++short_texts_;
      return;
    }
    ++long_;
    if (is_text) ++long_texts_;
    const auto padding = cipher.padding(encrypted);
    padding_ += padding;
    if (padding != 0) ++padded_;
  }

  bool is_empty() const { return short_ + long_ == 0; }
  bool password_is_right() const {
    return long_texts_ != 0 || 2 * short_texts_ > short_ || (2 * padded_ > long_ && padding_ >= kEnoughPadding);
  }

 private:
  /// By chance in one of 2^24 cases.
  static constexpr std::size_t kEnoughPadding = 3;

  std::size_t short_ = 0, short_texts_ = 0, long_ = 0, long_texts_ = 0;
  std::size_t padded_ = 0, padding_ = 0;  ///< of the long ones
};

/// Why a signature does not fit.
Error explain(const KeyringFile& file, const Cipher& cipher) {
  Evidence evidence;
  for (const auto& one : file.interfaces) {
    evidence.add(one.password, cipher);
    evidence.add(one.authentication, cipher);
  }
  for (const auto& one : file.devices) {
    evidence.add(one.management_password, cipher);
    evidence.add(one.authentication, cipher);
  }
  if (evidence.is_empty()) return {ErrorCode::kRefused, kEither, findings::kKeyringUnclear};
  return evidence.password_is_right() ? Error{ErrorCode::kInvalid, kChanged, findings::kKeyringChanged}
                                      : Error{ErrorCode::kRefused, kWrongPassword, findings::kKeyringPassword};
}

/// The password, or nothing where there is none.
Result<std::optional<secure::Secret>> optional_password(const Bytes& encrypted, const Cipher& cipher) {
  if (encrypted.empty()) return std::optional<secure::Secret>();
  auto password = cipher.password(encrypted);
  if (!password) return fail(password.error());
  return std::optional(std::move(*password));
}

}  // namespace

Result<secure::SessionKeys> TunnelAccess::session_keys() const {
  auto user_key = secure::user_key(password);
  if (!user_key) return fail(user_key.error());
  secure::SessionKeys keys{user, std::move(*user_key)};
  if (!authentication) return keys;
  auto code = secure::device_code(*authentication);
  if (!code) return fail(code.error());
  keys.device_code = std::move(*code);
  return keys;
}

// Opening.

Result<Keyring> Keyring::open(const KeyringFile& file, const secure::Secret& password) {
  const auto cipher = Cipher::make(password, file.created);
  return cipher ? open(file, *cipher) : Result<Keyring>(fail(cipher.error()));
}

Result<Keyring> Keyring::open(const KeyringFile& file, const Cipher& cipher) {
  const auto fits = cipher.signed_by_this(file);
  if (!fits) return fail(fits.error());
  if (!*fits) return fail(explain(file, cipher));
  Keyring keyring;
  if (auto done = keyring.decrypt(file, cipher); !done) return fail(done.error());
  return keyring;
}

Result<void> Keyring::decrypt(const KeyringFile& file, const Cipher& cipher) {
  const auto each = [&](const auto& entries) -> Result<void> {
    for (const auto& one : entries) {
      if (auto done = decrypt(one, cipher); !done) return done;
    }
    return {};
  };
  if (file.backbone) {
    if (auto done = decrypt(*file.backbone, cipher); !done) return done;
  }
  if (auto done = each(file.interfaces); !done) return done;
  if (auto done = each(file.group_keys); !done) return done;
  return each(file.devices);
}

Result<void> Keyring::decrypt(const KeyringFile::Backbone& from, const Cipher& cipher) {
  if (from.key.empty()) return {};
  auto key = cipher.key(from.key);
  if (!key) return fail(key.error());
  routing_ = RoutingAccess{from.multicast, {std::move(*key), from.latency}};
  return {};
}

Result<void> Keyring::decrypt(const KeyringFile::Interface& from, const Cipher& cipher) {
  auto password = optional_password(from.password, cipher);
  if (!password) return fail(password.error());
  auto code = optional_password(from.authentication, cipher);
  if (!code) return fail(code.error());
  Interface out;
  out.is_tunnel = from.type == "Tunneling";
  out.access.address = from.address;
  out.access.host = from.host;
  out.access.user = from.user.value_or(0);
  out.groups = from.groups;
  out.has_password = password->has_value();
  if (*password) out.access.password = std::move(**password);
  out.access.authentication = std::move(*code);
  interfaces_.push_back(std::move(out));
  return {};
}

Result<void> Keyring::decrypt(const KeyringFile::GroupKey& from, const Cipher& cipher) {
  auto key = cipher.key(from.key);
  if (!key) return fail(key.error());
  group_keys_.emplace_back(from.address, std::move(*key));
  return {};
}

Result<void> Keyring::decrypt(const KeyringFile::Device& from, const Cipher& cipher) {
  if (from.sequence) sequences_[from.address] = *from.sequence;
  auto code = optional_password(from.authentication, cipher);
  if (!code) return fail(code.error());
  if (*code) device_codes_[from.address] = std::move(**code);
  return {};
}

// Tunnels.

TunnelAccess Keyring::access_of(const Interface& interface) const {
  auto access = interface.access;
  if (access.authentication) return access;
  const auto code = device_codes_.find(access.host);
  if (code != device_codes_.end()) access.authentication = code->second;
  return access;
}

/// `1.1.10 and 1.1.11 of 1.1.0`, for error texts.
std::string Keyring::tunnels_text() const {
  std::map<wire::IndividualAddress, std::string> by_host;
  for (const auto& one : interfaces_) {
    if (!one.is_tunnel || !one.has_password) continue;
    auto& text = by_host[one.access.host];
    text += (text.empty() ? "" : ", ") + to_string(one.access.address);
  }
  std::string all;
  for (const auto& [host, text] : by_host)
    all += fmt::format("{}{} (interface {})", all.empty() ? "" : "; ", text, to_string(host));
  return all.empty() ? std::string("none") : all;
}

bool Keyring::has_secure_tunnel() const {
  return std::any_of(interfaces_.begin(), interfaces_.end(), [](const auto& one) { return one.is_secure_tunnel(); });
}

Result<TunnelAccess> Keyring::tunnel(const Selection& selection) const {
  return selection.tunnel ? wanted_tunnel(*selection.tunnel) : free_tunnel(selection);
}

Result<TunnelAccess> Keyring::wanted_tunnel(wire::IndividualAddress address) const {
  const auto found = std::find_if(interfaces_.begin(), interfaces_.end(),
                                  [&](const auto& one) { return one.is_tunnel && one.access.address == address; });
  if (found == interfaces_.end())
    return fail(ErrorCode::kNotFound,
                fmt::format("the keyring has no tunnel {}, only: {}", to_string(address), tunnels_text()),
                findings::kKeyringNoTunnel);
  if (found->access.user == 0 || !found->has_password)
    return fail(ErrorCode::kNotFound,
                fmt::format("the keyring has no user and password for the tunnel {}, only for: {}", to_string(address),
                            tunnels_text()),
                findings::kKeyringNoUser);
  return access_of(*found);
}

Result<TunnelAccess> Keyring::free_tunnel(const Selection& selection) const {
  std::vector<const Interface*> all;
  std::set<wire::IndividualAddress> hosts;
  for (const auto& one : interfaces_) {
    if (!one.is_secure_tunnel()) continue;
    if (selection.server && number(one.access.host) != 0 && one.access.host != *selection.server) continue;
    all.push_back(&one);
    hosts.insert(one.access.host);
  }
  if (all.empty())
    return fail(ErrorCode::kNotFound,
                selection.server ? fmt::format("the keyring has no tunnel of the interface {}, only: {}",
                                               to_string(*selection.server), tunnels_text())
                                 : std::string("the keyring has no tunnel with a user and a password"),
                findings::kKeyringNoTunnel);
  if (!selection.server && hosts.size() > 1)
    return fail(ErrorCode::kInvalid,
                fmt::format("the keyring has tunnels of several interfaces, name one: {}", tunnels_text()),
                findings::kKeyringSeveralInterfaces);
  std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->access.user < b->access.user; });
  for (const auto* one : all) {
    if (std::find(selection.taken.begin(), selection.taken.end(), one->access.address) == selection.taken.end())
      return access_of(*one);
  }
  return fail(ErrorCode::kBusy, fmt::format("all tunnels of the keyring are in use: {}", tunnels_text()),
              findings::kKeyringTunnelsInUse);
}

// Groups.

secure::GroupKeys Keyring::groups() const {
  secure::GroupKeys out;
  out.sequences = sequences_;
  for (const auto& [address, key] : group_keys_) out.groups[address].key = key;
  add_links(out);
  return out;
}

void Keyring::add_links(secure::GroupKeys& keys) const {
  for (const auto& interface : interfaces_) {
    const auto own = interface.access.address;
    for (const auto& group : interface.groups) {
      const auto found = keys.groups.find(group.address);
      if (found == keys.groups.end()) continue;
      auto& entry = found->second;
      entry.senders.insert(group.senders.begin(), group.senders.end());
      if (!entry.may_send) entry.may_send.emplace();
      entry.may_send->insert(group.senders.begin(), group.senders.end());
      if (number(own) == 0) continue;  // of USB: no line has this address
      entry.may_send->insert(own);
      entry.senders_for[own].insert(group.senders.begin(), group.senders.end());
    }
  }
}

}  // namespace rubicon::networks::knx::keyring
