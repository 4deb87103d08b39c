#include "networks/knx/knx_options.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/project/project.h"
#include "networks/knx/secure/passwords.h"
#include "rubicon/key.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx {

namespace {

/// Groups of KNXnet/IP routing (knx.md, section 2): 224.0.23.12 to 239.255.255.255.
constexpr std::uint32_t kMinMulticast = 0xe000170c, kMaxMulticast = 0xefffffff;

/// Bytes of an APDU without and with extended frames (KNX 3/3/2).
constexpr std::int64_t kShortApdu = 15, kLongApdu = 254;

/// The group or individual address under a key; nullopt if it is absent or, with an error, not an address.
template <class Parse>
auto read_address(ConfigReader& options, const std::string& key, Parse parse) {
  std::optional<typename std::invoke_result_t<Parse, std::string_view>::value_type> found;
  const auto text = options.text(key, "");
  if (text.empty()) return found;
  if (auto parsed = parse(text)) {
    found = *parsed;
  } else {
    options.error(key, parsed.error().text);
  }
  return found;
}

line::TelegramQueue::Limits read_limits(ConfigReader& options) {
  line::TelegramQueue::Limits limits;
  limits.rate = options.real("telegrams-per-second", limits.rate, 0, 1'000'000);
  limits.burst = static_cast<unsigned>(options.integer("burst", limits.burst, 1, 1000));
  return limits;
}

/// `host: 10.0.0.9`, or a list: the first is preferred, the others are used while it cannot be.
void read_hosts(ConfigReader& options, LineOptions& out) {
  if (!options.has("host")) {
    options.required_text("host", "the name or address of the interface, such as 192.168.1.10");
    return;
  }
  out.hosts = options.texts("host");
  const auto* node = options.node("host");
  if (out.hosts.empty() && node->kind == ConfigNode::Kind::kList)
    options.error("host", "is an empty list, expected the name or address of an interface, or several");
  std::set<std::string> seen;
  for (const auto& host : out.hosts) {
    if (const auto fault = base::host_fault(host); !fault.empty()) options.error("host", fault);
    if (!seen.insert(groups::to_lower(host)).second)
      options.error("host", fmt::format("names {} twice, expected different interfaces", model::quoted(host)));
  }
  if (!out.hosts.empty()) out.tunnel.host = out.hosts.front();
  const bool several = out.hosts.size() > 1;
  if (several) {
    for (const auto* key : {"tunnel-address", "local-port"})
      if (options.has(key))
        options.error(key, "is of one interface, and 'host' names several: expected only one of both");
  }
  if (!several && options.has("gateway-check"))
    options.error("gateway-check", "is given without a second host, expected 'host: [FIRST, SECOND]'");
  out.gateway_check = options.duration_or_never("gateway-check", out.gateway_check);
  if (out.gateway_check && *out.gateway_check < std::chrono::seconds(10))
    options.error("gateway-check", "expected at least 10s, or never");
}

void read_tunnel(ConfigReader& options, line::TunnelOptions& out) {
  out.port = static_cast<std::uint16_t>(options.integer("port", out.port, 1, 65535));
  out.local_port = static_cast<std::uint16_t>(options.integer("local-port", 0, 0, 65535));
  const auto nat = options.choice("nat", "auto", {"auto", "yes", "no"});
  out.nat = nat == "auto"  ? line::TunnelOptions::Nat::kAuto
            : nat == "yes" ? line::TunnelOptions::Nat::kOn
                           : line::TunnelOptions::Nat::kOff;
  out.wanted = read_address(options, "tunnel-address", wire::parse_individual);
  if (options.has("max-apdu"))
    out.max_apdu = static_cast<std::uint16_t>(options.integer("max-apdu", kShortApdu, kShortApdu, kLongApdu));
  out.limits = read_limits(options);
}

/// An IPv4 address in host byte order.
std::optional<std::uint32_t> parse_ipv4(const std::string& text) {
  in_addr address{};
  if (::inet_pton(AF_INET, text.c_str(), &address) != 1) return {};
  return ntohl(address.s_addr);
}

void read_routing(ConfigReader& options, line::RoutingOptions& out) {
  out.group.address = options.text("multicast", out.group.address);
  out.group.port = static_cast<std::uint16_t>(options.integer("port", out.group.port, 1, 65535));
  out.interface_address = options.text("interface", out.interface_address);
  if (options.has("interface") && !parse_ipv4(out.interface_address))
    options.error("interface",
                  fmt::format("is {}, expected an IPv4 address of this host", model::quoted(out.interface_address)));
  const auto group = parse_ipv4(out.group.address);
  if (!group || *group < kMinMulticast || *group > kMaxMulticast)
    options.error("multicast", fmt::format("is {}, expected a multicast address from 224.0.23.12 on",
                                           model::quoted(out.group.address)));
  out.ttl = static_cast<std::uint8_t>(options.integer("ttl", out.ttl, 1, 255));
  if (const auto own = read_address(options, "address", wire::parse_individual)) out.address = *own;
  out.limits = read_limits(options);
}

void read_line(ConfigReader& options, LineOptions& out) {
  const auto via = options.choice("via", "tunnel", {"tunnel", "tunnel-tcp", "routing"});
  out.via = via == "tunnel" ? Via::kTunnel : via == "routing" ? Via::kRouting : Via::kTunnelTcp;
  out.tunnel.via = out.via == Via::kTunnelTcp ? line::TunnelOptions::Via::kTcp : line::TunnelOptions::Via::kUdp;
  if (out.via == Via::kRouting) {
    out.multicast_given = options.has("multicast");
    read_routing(options, out.routing);
  } else {
    read_hosts(options, out);
    read_tunnel(options, out.tunnel);
  }
}

/// One of `tuple` and `clock`.
void read_source(ConfigReader& entry, Exposure& exposure) {
  if (entry.has("clock")) {
    if (entry.has("tuple")) entry.error("clock", "expected 'clock' or 'tuple', not both");
    exposure.clock = entry.choice("clock", "local", {"local", "utc"}) == "utc" ? ClockZone::kUtc : ClockZone::kLocal;
    exposure.tuple = "clock";
    return;
  }
  exposure.tuple = entry.required_text("tuple", "the key of a tuple; or 'clock'");
  const auto pattern = Pattern::parse(exposure.tuple);
  if (!exposure.tuple.empty() && (!pattern || !pattern->exact()))
    entry.error("tuple", pattern ? "is a pattern, expected one tuple" : pattern.error().text);
}

void read_exposure(const std::string& key, ConfigReader& entry, std::vector<Exposure>& out) {
  Exposure exposure;
  if (auto parsed = wire::parse_group(key)) {
    exposure.address = *parsed;
  } else {
    entry.error("", parsed.error().text);
  }
  read_source(entry, exposure);
  const auto dpt = entry.required_text("dpt", "a data point type, such as 9.001");
  if (auto id = dpt::parse_dpt(dpt); id && dpt::find_dpt(*id)) {
    exposure.dpt = *id;
  } else if (!dpt.empty()) {
    entry.error("dpt", id ? fmt::format("there is no data point type {}", to_string(*id)) : id.error().text);
  }
  if (exposure.clock && dpt::find_dpt(exposure.dpt) && !is_clock_type(exposure.dpt))
    entry.error("dpt",
                fmt::format("is {}, expected the type of a clock: 10.001, 11.001 or 19.001", to_string(exposure.dpt)));
  exposure.on_change = entry.boolean("on-change", true);
  exposure.pause = entry.duration("pause", exposure.pause);
  exposure.every =
      entry.duration_or_never("every", exposure.clock ? std::optional<Duration>(std::chrono::hours(1)) : std::nullopt);
  if (exposure.every && *exposure.every < std::chrono::seconds(1))
    entry.error("every", "expected at least 1s, or never");
  const bool twice =
      std::any_of(out.begin(), out.end(), [&](const auto& other) { return other.address == exposure.address; });
  if (twice) entry.error("", fmt::format("{} is exposed twice", to_string(exposure.address)));
  out.push_back(std::move(exposure));
}

/// An exposed address must not belong to a point too, because the network itself answers reads of it.
void check_exposures(ConfigReader& options, const KnxOptions& out) {
  std::set<wire::GroupAddress> exposed;
  for (const auto& one : out.exposures) exposed.insert(one.address);
  for (const auto& point : out.points) {
    std::vector<wire::GroupAddress> own = point.listen;
    own.push_back(point.address);
    if (point.state) own.push_back(*point.state);
    for (const auto address : own) {
      if (exposed.contains(address))
        options.error("expose", fmt::format("{} is also an address under groups", to_string(address)));
    }
  }
}

/// A group file in YAML, as `rubicon knx import` writes it.
groups::Import read_group_file(const network::NetworkConfig& config, std::string_view text, const std::string& path) {
  groups::Import out;
  auto& options = config.options;
  if (config.read_yaml == nullptr) {
    options.error("import", "this program does not read group files in YAML, expected an ETS export");
    return out;
  }
  const auto root = config.read_yaml(text, path);
  if (!root) {
    options.error("import", root.error().text);
    return out;
  }
  ConfigReader file(*root, "", options.errors());
  groups::read_groups(file, out.points);
  out.secured = groups::read_secured_groups(file);
  out.report.notation = groups::read_notation(file).value_or(wire::Notation::kThreeLevel);
  file.finish();
  return out;
}

/// One line for the log; `rubicon knx import` prints the whole report.
std::string summary_of(const groups::Report& report, const std::string& path) {
  return fmt::format("{}: {}, {} addresses, {} without a type, {} warnings, {} errors; `rubicon knx import` lists them",
                     path, report.form, report.taken, report.untyped, report.warnings, report.errors);
}

/// A path of the configuration, from the folder of its file.
std::string path_of(const network::NetworkConfig& config, const std::string& name) {
  return std::filesystem::path(base::resolve_path(config.directory, name)).lexically_normal().string();
}

/// The points of a project of ETS.
Result<groups::Import> import_project(const network::NetworkConfig& config, transport::Transports& transports,
                                      std::unique_ptr<transport::FileSource> file, const std::string& path,
                                      bool guess) {
  const auto name = config.options.text("import-password-file", "");
  std::optional<secure::Secret> password;
  if (!name.empty()) {
    auto read = secure::read_password_file(transports, path_of(config, name));
    if (!read) return fail(read.error());
    password = std::move(*read);
  }
  auto imported = project::import_project(std::move(file), path, {password ? &*password : nullptr}, {guess, {}});
  if (!imported && imported.error().code == ErrorCode::kRefused)
    return fail(imported.error().code,
                imported.error().text + (password ? secure::password_source(*password, path_of(config, name))
                                                  : ": write it to a file and name that in 'import-password-file'"));
  return imported;
}

/// A project, an ETS export or a group file.
groups::Import import_groups(const network::NetworkConfig& config, transport::Transports& transports,
                             const std::string& name, bool guess, std::string& report) {
  const auto path = path_of(config, name);
  const auto refused = [&](const Error& error) {
    config.options.error("import", error.text);
    return groups::Import();
  };
  auto file = transports.open_file(path);
  if (!file) return refused(file.error());
  const auto is_project = project::is_project(**file, path);
  if (!is_project) return refused(is_project.error());
  if (!*is_project && config.options.has("import-password-file"))
    config.options.error("import-password-file", "is only for projects of ETS (.knxproj)");
  Result<groups::Import> imported = groups::Import{};
  if (*is_project) {
    imported = import_project(config, transports, std::move(*file), path, guess);
  } else {
    const auto text = transport::read_text(transports, path, groups::kMaxListBytes);
    if (!text) return refused(text.error());
    if (path.ends_with(".yaml") || path.ends_with(".yml")) return read_group_file(config, *text, path);
    imported = groups::import_text(*text, path, {guess, {}});
  }
  if (!imported) return refused(imported.error());
  report = summary_of(imported->report, path);
  return std::move(*imported);
}

void read_points(const network::NetworkConfig& config, transport::Transports& transports, KnxOptions& out) {
  ConfigReader& options = config.options;
  groups::read_groups(options, out.points);
  out.secured = groups::read_secured_groups(options);
  const auto notation = groups::read_notation(options);
  out.notation = notation.value_or(out.notation);
  const bool guess = options.boolean("guess", true);
  const auto name = options.text("import", "");
  if (name.empty()) {
    if (options.has("import-password-file"))
      options.error("import-password-file", "is given without 'import', expected both or none");
    return;
  }
  std::set<wire::GroupAddress> configured;
  for (const auto& point : out.points) {
    configured.insert(point.address);
    if (point.state) configured.insert(*point.state);
  }
  auto imported = import_groups(config, transports, name, guess, out.report);
  out.secured = groups::joined(out.secured, imported.secured);
  if (!notation) out.notation = imported.report.notation;
  for (auto& point : imported.points) {
    if (configured.contains(point.address)) continue;
    if (point.state && configured.contains(*point.state)) {
      point.state.reset();
      point.state_name.clear();
    }
    out.points.push_back(std::move(point));
  }
  for (const auto& conflict : conflicts(out.points)) options.error("import", conflict);
}

}  // namespace

KnxOptions read_knx_options(const network::NetworkConfig& config, transport::Transports& transports) {
  ConfigReader& options = config.options;
  KnxOptions out;
  read_line(options, out.line);
  out.secure = read_secure_options(config, transports, out.line);
  read_points(config, transports, out);
  for (auto& [key, entry] : options.maps("expose")) read_exposure(key, entry, out.exposures);
  check_exposures(options, out);
  auto capture = options.map("capture");
  out.capture.age = capture.duration("keep", out.capture.age);
  out.capture.bytes = static_cast<std::size_t>(capture.size("size", out.capture.bytes, 0, 64UL << 20));
  capture.finish();
  return out;
}

}  // namespace rubicon::networks::knx
