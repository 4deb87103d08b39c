#include "networks/knx/keyring/keyring.h"

#include <fmt/format.h>

#include <set>

#include "apps/rubicon/knx/commands.h"
#include "apps/rubicon/output/tuple_text.h"
#include "model/json_members.h"
#include "networks/knx/secure/passwords.h"
#include "transport/local_transports.h"

namespace rubicon::cli::knx {

namespace {

using networks::knx::keyring::Keyring;
using networks::knx::keyring::KeyringFile;
using networks::knx::keyring::TunnelAccess;
using networks::knx::wire::IndividualAddress;

struct KeyringOptions {
  std::string file, password_file, tunnel, server;

  /// One tunnel is asked for.
  bool picks() const { return !tunnel.empty() || !server.empty(); }
};

/// A tunnel that would be used, or why there is none.
struct Pick {
  IndividualAddress server{};
  Result<TunnelAccess> access;
};

/// The addresses of the options.
Result<Keyring::Selection> selection_of(const KeyringOptions& options) {
  Keyring::Selection selection;
  for (const auto& [text, into] :
       {std::pair(&options.tunnel, &selection.tunnel), std::pair(&options.server, &selection.server)}) {
    if (text->empty()) continue;
    const auto address = networks::knx::wire::parse_individual(*text);
    if (!address) return fail(address.error());
    *into = *address;
  }
  return selection;
}

/// The wanted tunnel, else one of each server.
std::vector<Pick> picks_of(const Keyring& keyring, const KeyringFile& file, const Keyring::Selection& selection) {
  std::vector<Pick> picks;
  if (selection.tunnel || selection.server) {
    picks.push_back({selection.server.value_or(IndividualAddress{}), keyring.tunnel(selection)});
    return picks;
  }
  std::set<IndividualAddress> servers;
  for (const auto& one : file.interfaces) {
    if (one.type == "Tunneling" && one.user && !one.password.empty()) servers.insert(one.host);
  }
  for (const auto server : servers) picks.push_back({server, keyring.tunnel({{}, server})});
  return picks;
}

// As JSON.

template <class Senders>
Line senders_json(const Senders& senders) {
  Line all = Line::array();
  for (const auto sender : senders) all.push_back(to_string(sender));
  return all;
}

Line as_json(const KeyringFile::Interface& one) {
  Line line{{"type", one.type}};
  if (number(one.address) != 0) line["address"] = to_string(one.address);
  if (number(one.host) != 0) line["server"] = to_string(one.host);
  if (one.user) line["user"] = *one.user;
  line["password"] = !one.password.empty();
  line["authentication"] = !one.authentication.empty();
  line["groups"] = Line::array();
  for (const auto& group : one.groups)
    line["groups"].push_back({{"address", to_string(group.address)}, {"senders", senders_json(group.senders)}});
  return line;
}

Line as_json(const KeyringFile::Device& one) {
  Line line{{"address", to_string(one.address)},
            {"tool-key", !one.tool_key.empty()},
            {"management-password", !one.management_password.empty()},
            {"authentication", !one.authentication.empty()}};
  if (one.sequence) line["sequence"] = *one.sequence;
  return line;
}

Line as_json(const Pick& pick, const Keyring& keyring) {
  Line line;
  if (number(pick.server) != 0) line["server"] = to_string(pick.server);
  if (!pick.access) {
    line["error"] = pick.access.error().text;
    return line;
  }
  line["tunnel"] = to_string(pick.access->address);
  line["user"] = pick.access->user;
  line["authentication"] = pick.access->authentication.has_value();
  line["groups"] = Line::array();
  const auto own = pick.access->address;
  for (const auto& [group, entry] : keyring.groups().groups)
    line["groups"].push_back({{"address", to_string(group)},
                              {"write", entry.may_send_from(own)},
                              {"senders", senders_json(entry.senders_to(own))}});
  return line;
}

Line as_json(const KeyringFile& file, const std::optional<Keyring>& keyring, const std::vector<Pick>& picks) {
  Line line{{"project", file.project}, {"created-by", file.created_by}, {"created", file.created}};
  line["signature"] = keyring ? "good" : "not-checked";
  if (file.backbone)
    line["backbone"] = {{"group", file.backbone->multicast},
                        {"latency-ms", file.backbone->latency / std::chrono::milliseconds(1)},
                        {"key", !file.backbone->key.empty()}};
  for (const auto* name : {"interfaces", "group-keys", "devices"}) line[name] = Line::array();
  for (const auto& one : file.interfaces) line["interfaces"].push_back(as_json(one));
  for (const auto& one : file.group_keys) line["group-keys"].push_back(to_string(one.address));
  for (const auto& one : file.devices) line["devices"].push_back(as_json(one));
  if (!keyring) return line;
  line["picked"] = Line::array();
  for (const auto& pick : picks) line["picked"].push_back(as_json(pick, *keyring));
  return line;
}

// As text.

std::string listed(std::initializer_list<std::pair<bool, std::string_view>> parts) {
  std::string text;
  for (const auto& [there, name] : parts) {
    if (there) text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
  }
  return text.empty() ? "none" : text;
}

void put(Output& out, std::string_view what, const std::string& text) {
  out.line(fmt::format("{:<11}{}", what, printable(text)));
}

void put(Output& out, const KeyringFile::Interface& one) {
  const auto user = one.user ? fmt::format(", user {}", *one.user) : std::string();
  const auto host = number(one.host) != 0 ? " of " + to_string(one.host) : std::string();
  put(out, "interface",
      fmt::format("{} {}{}{}; secrets: {}", to_string(one.address), one.type, host, user,
                  listed({{!one.password.empty(), "password"}, {!one.authentication.empty(), "authentication code"}})));
  for (const auto& group : one.groups) {
    std::string senders;
    for (const auto sender : group.senders) senders += " " + to_string(sender);
    put(out, "  group",
        fmt::format("{} takes telegrams of{}", to_string(group.address), senders.empty() ? " no device" : senders));
  }
}

void put(Output& out, const KeyringFile::Device& one) {
  const auto sequence = one.sequence ? fmt::format("; sequence number {}", *one.sequence) : std::string();
  put(out, "device",
      fmt::format("{}; secrets: {}{}", to_string(one.address),
                  listed({{!one.tool_key.empty(), "tool key"},
                          {!one.management_password.empty(), "management password"},
                          {!one.authentication.empty(), "authentication code"}}),
                  sequence));
}

void put(Output& out, const Pick& pick, const Keyring& keyring) {
  if (!pick.access) return put(out, "picked", "no tunnel: " + pick.access.error().text);
  const auto& access = *pick.access;
  put(out, "picked",
      fmt::format("tunnel {} of {}, user {}{}", to_string(access.address), to_string(access.host), access.user,
                  access.authentication ? "" : "; no authentication code, so the interface cannot be verified"));
  for (const auto& [group, entry] : keyring.groups().groups)
    put(out, "  group",
        fmt::format("{} {}, senders: {}", to_string(group),
                    entry.may_send_from(access.address) ? "read and write" : "read only",
                    entry.senders_to(access.address).size()));
}

void put(Output& out, const KeyringFile& file, const std::optional<Keyring>& keyring, const std::vector<Pick>& picks) {
  put(out, "project", fmt::format("{}, {}, {}", file.project, file.created_by, file.created));
  put(out, "signature", keyring ? "good" : "not checked: no password was given");
  if (file.backbone)
    put(out, "backbone",
        fmt::format("{}, latency {} ms; secrets: {}", file.backbone->multicast,
                    file.backbone->latency / std::chrono::milliseconds(1),
                    file.backbone->key.empty() ? "none" : "key"));
  for (const auto& one : file.interfaces) put(out, one);
  for (const auto& one : file.group_keys) put(out, "group", to_string(one.address) + "; secrets: key");
  for (const auto& one : file.devices) put(out, one);
  if (!keyring) return;
  for (const auto& pick : picks) put(out, pick, *keyring);
}

int failed(const std::string& why) {
  print_error(printable(why));
  return kFailed;
}

/// The keyring, opened if its password is given.
Result<std::optional<Keyring>> open(transport::Transports& disk, const KeyringOptions& options,
                                    const KeyringFile& file) {
  namespace secure = networks::knx::secure;
  const auto password = secure::find_password(disk, options.password_file, secure::kPasswordVariable);
  if (!password) return fail(password.error());
  if (!password->has_value() && options.picks())
    return fail(ErrorCode::kInvalid, fmt::format("to pick a tunnel needs the password of the keyring: --password-file "
                                                 "FILE, or {}",
                                                 secure::kPasswordVariable));
  if (!password->has_value()) return std::optional<Keyring>();
  auto opened = Keyring::open(file, **password);
  if (!opened) {
    const bool refused = opened.error().code == ErrorCode::kRefused;
    return fail(opened.error().code,
                fmt::format("{}: {}{}", options.file, opened.error().text,
                            refused ? secure::password_source(**password, options.password_file) : ""));
  }
  return std::optional(std::move(*opened));
}

int show(const Settings& settings, const KeyringOptions& options) {
  const auto selection = selection_of(options);
  if (!selection) return failed(selection.error().text);
  transport::LocalTransports disk;
  const auto file = networks::knx::keyring::read_keyring(disk, options.file);
  if (!file) return failed(file.error().text);
  const auto keyring = open(disk, options, *file);
  if (!keyring) return failed(keyring.error().text);
  const auto picks = *keyring ? picks_of(**keyring, *file, *selection) : std::vector<Pick>();
  Output out(1);
  if (settings.json) {
    out.line(model::dump(as_json(*file, *keyring, picks)));
  } else {
    put(out, *file, *keyring, picks);
  }
  const bool found = !options.picks() || picks.front().access.has_value();
  return ended(out, found ? kGood : kFailed);
}

}  // namespace

void add_keyring(Cli& cli, CLI::App* under) {
  const auto options = std::make_shared<KeyringOptions>();
  auto* app = cli.command(
      {"keyring", "Show what is in a keyring of ETS (.knxkeys), without its secrets",
       "  rubicon knx keyring hall.knxkeys                                 # without a password nothing is verified\n"
       "  rubicon knx keyring hall.knxkeys --password-file hall.password   # and which tunnel would be used\n"
       "  rubicon knx keyring hall.knxkeys --password-file hall.password --server 1.1.0\n"
       "The password is the line in a file that only you may read, or the value of RUBICON_KNX_PASSWORD.\n",
       under},
      [options](const Settings& settings) { return show(settings, *options); });
  app->add_option("FILE", options->file, "keyring exported by ETS")->required();
  app->add_option("--password-file", options->password_file, "file with the password of the keyring")
      ->type_name("FILE");
  app->add_option("--tunnel", options->tunnel, "pick the tunnel with this address")->type_name("ADDRESS");
  app->add_option("--server", options->server, "pick a tunnel of the interface with this address")
      ->type_name("ADDRESS");
}

}  // namespace rubicon::cli::knx
