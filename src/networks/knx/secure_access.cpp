#include "networks/knx/secure_access.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/text.h"
#include "model/findings.h"
#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure/passwords.h"

namespace rubicon::networks::knx {

namespace {

using Policy = SecureOptions::Policy;
using Taken = std::span<const wire::IndividualAddress>;

constexpr std::size_t kKeyFileBytes = 64;
/// Tunnels of one interface that are tried: interfaces have fewer.
constexpr std::size_t kMaxTunnels = 32;

/// Reads the options of KNX Secure and the files that they name.
class Reader {
 public:
  Reader(const network::NetworkConfig& config, transport::Transports& transports, const LineOptions& line)
      : config_(config), options_(config.options), transports_(transports), via_(line.via), hosts_(line.hosts.size()) {}

  SecureOptions read() {
    SecureOptions out;
    read_keyring(out);
    if (via_ == Via::kRouting) {
      read_backbone(out);
    } else {
      read_user(out);
    }
    read_group_keys(out);
    read_policy(out);
    return out;
  }

 private:
  std::string path_of(const std::string& name) const {
    return std::filesystem::path(base::resolve_path(config_.directory, name)).lexically_normal().string();
  }

  /// The password in the file that `key` names; nullopt, with an error, if it cannot be read.
  std::optional<secure::Secret> password_of(const std::string& key) {
    auto password = secure::read_password_file(transports_, path_of(options_.text(key, "")));
    if (password) return std::move(*password);
    options_.error(key, password.error().text);
    return {};
  }

  void read_keyring(SecureOptions& out) {
    const auto name = options_.text("keyring", "");
    if (name.empty()) return refuse_without_keyring();
    SecureOptions::KeyringSource source;
    source.path = path_of(name);
    auto file = keyring::read_keyring(transports_, source.path);
    if (file) {
      source.file = std::move(*file);
    } else {
      options_.error("keyring", file.error().text);
    }
    read_keyring_password(source);
    read_server(source);
    out.keyring = std::move(source);
  }

  void refuse_without_keyring() {
    for (const auto* key : {"keyring-password-file", "server-address"})
      if (options_.has(key)) options_.error(key, "is given without 'keyring', expected both or none");
  }

  void read_keyring_password(SecureOptions::KeyringSource& source) {
    const auto name = options_.text("keyring-password-file", "");
    source.password_path = name.empty() ? name : path_of(name);
    auto password = secure::find_password(transports_, source.password_path, secure::kPasswordVariable);
    if (!password) return options_.error("keyring-password-file", password.error().text);
    if (*password) return void(source.password = std::move(**password));
    options_.error("keyring-password-file",
                   fmt::format("is missing: it names a file with the password of the keyring (or set {})",
                               secure::kPasswordVariable));
  }

  void read_server(SecureOptions::KeyringSource& source) {
    const auto texts = options_.texts("server-address");
    std::vector<wire::IndividualAddress> servers;
    for (const auto& text : texts) {
      const auto address = wire::parse_individual(text);
      if (!address) return options_.error("server-address", address.error().text);
      servers.push_back(*address);
    }
    if (servers.size() == 1) source.server = servers.front();
    if (servers.size() < 2) return;
    source.servers = std::move(servers);
    if (source.servers.size() != hosts_)
      options_.error("server-address", fmt::format("has {} addresses, expected one for each of the {} hosts",
                                                   source.servers.size(), hosts_));
  }

  void read_user(SecureOptions& out) {
    for (const auto* key : {"backbone-key-file", "latency"})
      if (options_.has(key)) options_.error(key, "is an option of routing");
    if (!options_.has("user-password-file")) {
      for (const auto* key : {"user", "device-password-file"})
        if (options_.has(key)) options_.error(key, "is given without 'user-password-file'");
      return;
    }
    if (out.keyring)
      return options_.error("user-password-file", "cannot be given with 'keyring': expected one of them");
    SecureOptions::User user;
    user.number = static_cast<std::uint8_t>(options_.integer("user", user.number, 2, 127));
    if (auto password = password_of("user-password-file")) user.password = std::move(*password);
    if (options_.has("device-password-file")) user.device_password = password_of("device-password-file");
    out.user = std::move(user);
  }

  void read_backbone(SecureOptions& out) {
    for (const auto* key : {"user", "user-password-file", "device-password-file"})
      if (options_.has(key)) options_.error(key, "is an option of tunnels");
    if (!options_.has("backbone-key-file")) {
      if (options_.has("latency")) options_.error("latency", "is given without 'backbone-key-file'");
      return;
    }
    if (out.keyring) return options_.error("backbone-key-file", "cannot be given with 'keyring': expected one of them");
    SecureOptions::Backbone backbone;
    backbone.latency = options_.duration("latency", backbone.latency);
    if (backbone.latency < std::chrono::milliseconds(1) || backbone.latency > std::chrono::seconds(8))
      options_.error("latency", "expected 1ms to 8s");
    const auto text = password_of("backbone-key-file");
    auto bytes = base::from_hex(text && text->size() <= kKeyFileBytes ? text->text() : std::string_view());
    auto key = secure::Key::from(bytes ? ByteView(*bytes) : ByteView());
    if (bytes) secure::wipe(*bytes);
    if (text && !key) options_.error("backbone-key-file", "does not hold a key: expected 32 hexadecimal digits");
    if (key) backbone.key = std::move(*key);
    out.backbone = std::move(backbone);
  }

  void read_group_keys(SecureOptions& out) {
    if (!options_.has("group-keys-file")) return;
    SecureOptions::GroupKeysSource source;
    source.path = path_of(options_.text("group-keys-file", ""));
    auto keys = secure::read_group_keys_file(transports_, source.path);
    if (!keys) return options_.error("group-keys-file", keys.error().text);
    source.keys = std::move(*keys);
    out.group_keys = std::move(source);
  }

  /// Where keys are given, plain would be a surprise.
  void read_policy(SecureOptions& out) {
    const auto text = options_.choice("secure", out.secures_line() ? "require" : "allow", {"require", "allow", "off"});
    out.policy = text == "require" ? Policy::kRequire : text == "off" ? Policy::kOff : Policy::kAllow;
    if (out.policy == Policy::kRequire && !out.secures_line())
      options_.error("secure", via_ == Via::kRouting ? "require needs 'keyring' or 'backbone-key-file'"
                                                     : "require needs 'keyring' or 'user-password-file'");
    if (out.policy == Policy::kOff && (out.user || out.backbone))
      options_.error("secure", "is off, although a key for the line is given");
  }

  const network::NetworkConfig& config_;
  ConfigReader& options_;
  transport::Transports& transports_;
  Via via_;
  std::size_t hosts_;
};

Error in_file(const SecureOptions::KeyringSource& source, const Error& error) {
  return {error.code, fmt::format("{}: {}", source.path, error.text), error.finding};
}

/// Plain only where the keyring cannot mean anything else: an address that it does not have may be a typing error.
Result<void> derive_without_tunnels(const SecureOptions& options, const LineOptions& line, SecureAccess& out) {
  constexpr auto kNone = "the keyring has no tunnel with a user and a password";
  const bool named = line.tunnel.wanted || options.keyring->server || !options.keyring->servers.empty();
  if (options.policy == Policy::kAllow && !named) {
    out.plain = fmt::format("the line is plain: {}", kNone);
    return {};
  }
  return fail(in_file(*options.keyring, {ErrorCode::kNotFound,
                                         fmt::format("{}: its interfaces are plain. `secure: off` opens a plain "
                                                     "line; secured groups stay secured",
                                                     kNone),
                                         model::findings::kKeyringPlainTunnels}));
}

/// All tunnels of the interface at one of several hosts.
Result<void> add_gateways(const keyring::Keyring& keyring, const std::string& host,
                          std::optional<wire::IndividualAddress> server, std::vector<line::Gateway>& out) {
  std::vector<wire::IndividualAddress> taken;
  while (taken.size() < kMaxTunnels) {
    const auto access = keyring.tunnel({{}, server, taken});
    if (!access && taken.empty()) return fail(access.error());
    if (!access) break;
    auto keys = access->session_keys();
    if (!keys) return fail(keys.error());
    const bool known = number(access->address) != 0;
    out.push_back({host, std::move(*keys), known ? std::optional(access->address) : std::nullopt});
    if (!known) break;
    taken.push_back(access->address);
  }
  return {};
}

Result<void> derive_gateways(const SecureOptions& options, const keyring::Keyring& keyring, const LineOptions& line,
                             SecureAccess& out) {
  const auto& source = *options.keyring;
  for (std::size_t i = 0; i < line.hosts.size(); ++i) {
    const auto server = i < source.servers.size() ? std::optional(source.servers[i]) : source.server;
    if (auto done = add_gateways(keyring, line.hosts[i], server, out.gateways); !done)
      return fail(in_file(source, done.error()));
  }
  out.session = out.gateways.front().secure;
  return {};
}

Result<void> derive_tunnel(const SecureOptions& options, const keyring::Keyring& keyring, const LineOptions& line,
                           Taken taken, SecureAccess& out) {
  if (!keyring.has_secure_tunnel()) return derive_without_tunnels(options, line, out);
  if (line.hosts.size() > 1) return derive_gateways(options, keyring, line, out);
  const auto access = keyring.tunnel({line.tunnel.wanted, options.keyring->server, taken});
  if (!access) return fail(in_file(*options.keyring, access.error()));
  auto keys = access->session_keys();
  if (!keys) return fail(keys.error());
  out.session = std::move(*keys);
  if (number(access->address) != 0) out.tunnel = access->address;
  return {};
}

Result<void> derive_routing(const SecureOptions& options, const keyring::Keyring& keyring, SecureAccess& out) {
  if (keyring.routing()) {
    out.routing = keyring.routing()->keys;
    out.multicast = keyring.routing()->multicast;
    return {};
  }
  if (options.policy == Policy::kAllow) {
    out.plain = "the line is plain: the keyring has no backbone key for secure routing";
    return {};
  }
  return fail(in_file(*options.keyring, {ErrorCode::kNotFound,
                                         "it has no backbone key for secure routing; with "
                                         "'secure: allow' the line would be plain",
                                         model::findings::kKeyringNoBackbone}));
}

Result<SecureAccess> derive_from_keyring(const SecureOptions& options, const LineOptions& line, Taken taken) {
  const auto keyring = keyring::Keyring::open(options.keyring->file, options.keyring->password);
  if (!keyring) {
    auto error = in_file(*options.keyring, keyring.error());
    if (error.code == ErrorCode::kRefused)
      error.text += secure::password_source(options.keyring->password, options.keyring->password_path);
    return fail(std::move(error));
  }
  SecureAccess out;
  const bool routing = line.via == Via::kRouting;
  if (options.policy != Policy::kOff) {
    auto done = routing ? derive_routing(options, *keyring, out) : derive_tunnel(options, *keyring, line, taken, out);
    if (!done) return fail(done.error());
  }
  out.groups = keyring->groups();
  return out;
}

Result<SecureAccess> derive_from_user(const SecureOptions::User& user) {
  auto key = secure::user_key(user.password);
  if (!key) return fail(key.error());
  secure::SessionKeys keys{user.number, std::move(*key), {}};
  if (user.device_password) {
    auto code = secure::device_code(*user.device_password);
    if (!code) return fail(code.error());
    keys.device_code = std::move(*code);
  }
  SecureAccess out;
  out.session = std::move(keys);
  return out;
}

Result<SecureAccess> derive_line(const SecureOptions& options, const LineOptions& line, Taken taken) {
  if (options.keyring) return derive_from_keyring(options, line, taken);
  if (options.user) return derive_from_user(*options.user);
  SecureAccess out;
  if (options.backbone) out.routing = secure::RoutingKeys{options.backbone->key, options.backbone->latency};
  return out;
}

}  // namespace

bool same_access(const SecureOptions& one, const SecureOptions& other) {
  const auto same_keyring = [](const SecureOptions::KeyringSource& a, const SecureOptions::KeyringSource& b) {
    return a.path == b.path && a.file.signature == b.file.signature && a.file.signed_bytes == b.file.signed_bytes &&
           a.password == b.password && a.server == b.server && a.servers == b.servers;
  };
  const auto same_user = [](const SecureOptions::User& a, const SecureOptions::User& b) {
    return a.number == b.number && a.password == b.password && a.device_password == b.device_password;
  };
  const auto same_backbone = [](const SecureOptions::Backbone& a, const SecureOptions::Backbone& b) {
    return a.key == b.key && a.latency == b.latency;
  };
  const auto same = [](const auto& a, const auto& b, auto equal) {
    return a.has_value() == b.has_value() && (!a || equal(*a, *b));
  };
  const auto same_groups = [](const SecureOptions::GroupKeysSource& a, const SecureOptions::GroupKeysSource& b) {
    return a.keys == b.keys;
  };
  return one.policy == other.policy && same(one.group_keys, other.group_keys, same_groups) &&
         same(one.keyring, other.keyring, same_keyring) && same(one.user, other.user, same_user) &&
         same(one.backbone, other.backbone, same_backbone);
}

SecureOptions read_secure_options(const network::NetworkConfig& config, transport::Transports& transports,
                                  const LineOptions& line) {
  return Reader(config, transports, line).read();
}

Result<SecureAccess> derive_access(const SecureOptions& options, const LineOptions& line,
                                   std::span<const wire::IndividualAddress> taken) {
  auto access = derive_line(options, line, taken);
  if (access && options.group_keys) {
    const auto& more = options.group_keys->keys.groups;
    access->groups.groups.insert(more.begin(), more.end());
  }
  return access;
}

namespace {

constexpr std::size_t kNamed = 5;

/// `1/2/7, 1/2/8 and 3 more`.
std::string list_of(const std::vector<wire::GroupAddress>& groups) {
  std::string out;
  const auto named = groups.size() <= kNamed ? groups.size() : kNamed - 1;
  for (std::size_t i = 0; i < named; ++i) out += fmt::format("{}{}", i == 0 ? "" : ", ", to_string(groups[i]));
  return named == groups.size() ? out : fmt::format("{} and {} more", out, groups.size() - named);
}

}  // namespace

std::vector<wire::GroupAddress> add_without_keys(secure::GroupKeys& keys,
                                                 const std::vector<wire::GroupAddress>& secured) {
  std::vector<wire::GroupAddress> added;
  for (const auto group : secured) {
    if (keys.groups.try_emplace(group).second) added.push_back(group);
  }
  return added;
}

std::string explain_missing_keys(const std::vector<wire::GroupAddress>& groups, const SecureOptions& options) {
  if (groups.empty()) return {};
  const bool one = groups.size() == 1;
  return fmt::format("there {} for the secured group{} {}: nothing is sent to {} or taken from {}; {}",
                     one ? "is no key" : "are no keys", one ? "" : "s", list_of(groups), one ? "it" : "them",
                     one ? "it" : "them",
                     options.keyring      ? "export the keyring of the whole project from ETS again"
                     : options.group_keys ? "add them to the file of `group-keys-file`, or configure a `keyring` of ETS"
                                          : "export a keyring from ETS and configure `keyring`");
}

void add_missing_keys(const SecureOptions& secure, const LineOptions& line,
                      const std::vector<wire::GroupAddress>& secured, bool remembers,
                      std::vector<network::Missing>& all) {
  auto access = derive_access(secure, line);
  using Kind = network::Missing::Kind;
  if (!access)
    return all.push_back({secure.keyring ? "keyring" : "secure", access.error().text,
                          access.error().code == ErrorCode::kIo ? Kind::kOnHost : Kind::kWrong});
  if (!access->groups.groups.empty() && !remembers)
    all.push_back({secure.keyring ? "keyring" : "group-keys-file",
                   "its groups can only be read, and recorded telegrams are taken once more after each start: sequence "
                   "numbers need a state file (state: {file: ...})",
                   Kind::kWarning});
  if (access->routing && !remembers)
    all.push_back({secure.keyring ? "keyring" : "backbone-key-file",
                   "recorded telegrams of secure routing can be replayed after a restart: its timer needs a state file "
                   "(state: {file: ...})",
                   Kind::kWarning});
  const auto without = add_without_keys(access->groups, secured);
  if (!without.empty())
    all.push_back({secure.keyring ? "keyring" : "import", explain_missing_keys(without, secure), Kind::kWarning});
}

}  // namespace rubicon::networks::knx
