#include "networks/knx/keyring/keyring.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace rubicon::networks::knx::keyring {

namespace {

constexpr auto kChanged =
    "the keyring was changed after ETS exported it (its signature does not fit, although the password does): export it "
    "again";
constexpr auto kWrongPassword = "the password of the keyring is wrong";
constexpr auto kEither =
    "the password of the keyring is wrong, or the keyring was changed after ETS exported it: it holds no password that "
    "could show which";

/// Why a signature does not fit. A wrong password makes garbage of each stored one, which has valid padding by chance
/// only (1 in 256).
Error explain(const KeyringFile& file, const Cipher& cipher) {
  std::size_t stored = 0, good = 0;
  const auto look = [&](const Bytes& encrypted) {
    if (encrypted.empty()) return;
    ++stored;
    if (cipher.password(encrypted)) ++good;
  };
  for (const auto& one : file.interfaces) {
    look(one.password);
    look(one.authentication);
  }
  for (const auto& one : file.devices) {
    look(one.management_password);
    look(one.authentication);
  }
  if (stored == 0) return {ErrorCode::kRefused, kEither};
  return 2 * good > stored ? Error{ErrorCode::kInvalid, kChanged} : Error{ErrorCode::kRefused, kWrongPassword};
}

const KeyringFile::Group* find_group(const std::vector<KeyringFile::Group>& groups, wire::GroupAddress address) {
  const auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.address == address; });
  return found == groups.end() ? nullptr : &*found;
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
  if (file.backbone) {
    auto key = cipher.key(file.backbone->key);
    if (!key) return fail(key.error());
    routing_ = RoutingAccess{file.backbone->multicast, {std::move(*key), file.backbone->latency}};
  }
  for (const auto& one : file.interfaces) {
    Interface out;
    out.is_tunnel = one.type == "Tunneling";
    out.access.address = one.address;
    out.access.host = one.host;
    out.access.user = one.user.value_or(0);
    out.groups = one.groups;
    if (!one.password.empty()) {
      auto password = cipher.password(one.password);
      if (!password) return fail(password.error());
      out.access.password = std::move(*password);
      out.has_password = true;
    }
    if (!one.authentication.empty()) {
      auto code = cipher.password(one.authentication);
      if (!code) return fail(code.error());
      out.access.authentication = std::move(*code);
    }
    interfaces_.push_back(std::move(out));
  }
  for (const auto& one : file.group_keys) {
    auto key = cipher.key(one.key);
    if (!key) return fail(key.error());
    group_keys_.emplace_back(one.address, std::move(*key));
  }
  for (const auto& one : file.devices) {
    if (one.sequence) sequences_[one.address] = *one.sequence;
    if (one.authentication.empty()) continue;
    auto code = cipher.password(one.authentication);
    if (!code) return fail(code.error());
    device_codes_[one.address] = std::move(*code);
  }
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

Result<TunnelAccess> Keyring::tunnel(const Wish& wish) const {
  return wish.tunnel ? wanted_tunnel(*wish.tunnel) : free_tunnel(wish);
}

Result<TunnelAccess> Keyring::wanted_tunnel(wire::IndividualAddress address) const {
  const auto found = std::find_if(interfaces_.begin(), interfaces_.end(),
                                  [&](const auto& one) { return one.is_tunnel && one.access.address == address; });
  if (found == interfaces_.end())
    return fail(ErrorCode::kNotFound,
                fmt::format("the keyring has no tunnel {}, only: {}", to_string(address), tunnels_text()));
  if (found->access.user == 0 || !found->has_password)
    return fail(ErrorCode::kNotFound, fmt::format("the keyring has no user and password for the tunnel {}, only for: "
                                                  "{}",
                                                  to_string(address), tunnels_text()));
  return access_of(*found);
}

Result<TunnelAccess> Keyring::free_tunnel(const Wish& wish) const {
  std::vector<const Interface*> all;
  std::set<wire::IndividualAddress> hosts;
  for (const auto& one : interfaces_) {
    if (!one.is_tunnel || !one.has_password || one.access.user == 0) continue;
    if (wish.server && number(one.access.host) != 0 && one.access.host != *wish.server) continue;
    all.push_back(&one);
    hosts.insert(one.access.host);
  }
  if (all.empty())
    return fail(ErrorCode::kNotFound, wish.server
                                          ? fmt::format("the keyring has no tunnel of the interface {}, only: {}",
                                                        to_string(*wish.server), tunnels_text())
                                          : std::string("the keyring has no tunnel with a user and a password"));
  if (!wish.server && hosts.size() > 1)
    return fail(ErrorCode::kInvalid,
                fmt::format("the keyring has tunnels of several interfaces, name one: {}", tunnels_text()));
  std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->access.user < b->access.user; });
  for (const auto* one : all) {
    if (std::find(wish.taken.begin(), wish.taken.end(), one->access.address) == wish.taken.end())
      return access_of(*one);
  }
  return fail(ErrorCode::kBusy, fmt::format("all tunnels of the keyring are in use: {}", tunnels_text()));
}

// Groups.

secure::GroupKeys Keyring::groups(wire::IndividualAddress own) const {
  secure::GroupKeys out;
  out.sequences = sequences_;
  for (const auto& [address, key] : group_keys_) {
    auto& entry = out.groups[address];
    entry.key = key;
    const KeyringFile::Group* linked = nullptr;
    bool known = false, own_sends = false;
    for (const auto& interface : interfaces_) {
      const auto* group = find_group(interface.groups, address);
      if (group == nullptr) continue;
      known = true;
      own_sends = own_sends || std::find(group->senders.begin(), group->senders.end(), own) != group->senders.end();
      if (interface.access.address == own) linked = group;
      entry.senders.insert(group->senders.begin(), group->senders.end());
    }
    if (linked != nullptr) entry.senders = {linked->senders.begin(), linked->senders.end()};
    if (linked == nullptr) entry.senders.erase(own);
    entry.may_send = linked != nullptr || own_sends || !known;
  }
  return out;
}

}  // namespace rubicon::networks::knx::keyring
