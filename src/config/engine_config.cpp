#include "config/engine_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "base/text.h"
#include "transport/mqtt_tls.h"
#include "tuples/host/folder.h"

namespace rubicon::config {

namespace {

constexpr const char* kRealmFile = "realm.p7s";
constexpr std::size_t kMaxSpare = 8;
constexpr Duration kMaxBrokerLease = std::chrono::minutes(10);

void check_user(ConfigReader& mqtt, const transport::MqttOptions& line) {
  if (line.user.empty()) return;
  if (const auto good = tuples::mqtt::check_user(line.user); !good) mqtt.error("broker", good.error().text);
}

std::vector<base::HostPort> read_spare(ConfigReader& mqtt, std::uint16_t port) {
  std::vector<base::HostPort> spare;
  for (const auto& text : mqtt.texts("spare_brokers")) {
    const auto address = base::parse_host_port(text, port);
    if (address && base::host_fault(address->host).empty()) {
      spare.push_back(*address);
    } else {
      mqtt.error("spare_brokers", fmt::format("has '{}', expected HOST[:PORT]", base::one_line(text.substr(0, 60))));
    }
  }
  if (spare.size() > kMaxSpare) mqtt.error("spare_brokers", fmt::format("expected at most {}", kMaxSpare));
  return spare;
}

}  // namespace

MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory) {
  MqttSpaceSetup setup;
  auto mqtt = tuples.map("mqtt");
  setup.broker = transport::read_mqtt_broker(mqtt, directory);
  check_user(mqtt, setup.broker.line);
  setup.spare = read_spare(mqtt, setup.broker.line.port);
  setup.space = mqtt.text("space", setup.space);
  if (!tuples::mqtt::is_space(setup.space)) mqtt.error("space", "expected 1 to 64 of A-Z a-z 0-9 . _ -");
  setup.lease = mqtt.duration("lease", setup.lease);
  if (setup.lease < tuples::mqtt::kMinLease || setup.lease > kMaxBrokerLease)
    mqtt.error("lease", "expected from 13s to 10min: a broker notices a silent connection only so late");
  setup.trust_broker = mqtt.boolean("trust_broker", setup.trust_broker);
  setup.watch_all = mqtt.choice("watch", "met", {"met", "all"}) == "all";
  mqtt.finish();
  return setup;
}

Result<tuples::mqtt::SpaceOptions> MqttSpaceSetup::options(transport::Transports& transports) const {
  auto line = broker.with_password(transports);
  if (!line) return fail(std::move(line.error()));
  tuples::mqtt::SpaceOptions found;
  tuples::mqtt::SpaceBroker first{std::move(*line)};
  if (!first.line.user.empty()) {
    first.user = first.line.user;
  } else if (first.line.tls && !first.line.tls->certificate_file.empty()) {
    auto name = transport::certificate_name(first.line.tls->certificate_file);
    if (!name) return fail(std::move(name.error()));
    first.user = std::move(*name);
  }
  found.brokers = tuples::mqtt::with_spare(std::move(first), spare);
  found.space = space;
  found.lease = lease;
  found.trust_broker = trust_broker;
  found.watch_all = watch_all;
  return found;
}

std::string MqttSpaceSetup::realm_folder() const {
  const auto& tls = broker.line.tls;
  if (!tls || tls->ca_file.empty()) return {};
  const auto folder = std::filesystem::path(tls->ca_file).parent_path();
  std::error_code none;
  return std::filesystem::exists(folder / kRealmFile, none) ? folder.string() : std::string();
}

namespace {

using tuples::dds::DdsOptions;
using tuples::dds::DdsTransport;

constexpr Duration kMinLeaseTime = std::chrono::milliseconds(500);
constexpr Duration kMaxLease = std::chrono::seconds(60);
constexpr std::size_t kMaxPeerCount = 64;
constexpr std::size_t kMaxTag = 64;
constexpr std::size_t kMaxInterface = 15;  // of Linux, net/if.h
constexpr std::size_t kMaxHostText = 253;  // RFC 1035, 2.3.4
constexpr const char* kLoopback = "lo";
constexpr const char* kReachesNobody =
    "lo reaches no other host, expected another interface too, such as interfaces: [eth0]";

bool is_made_of(std::string_view text, std::string_view more) {
  return std::all_of(text.begin(), text.end(), [more](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || more.find(c) != more.npos;
  });
}

/// About an item of a list, or about the single value that is written instead of a list.
void item_error(ConfigReader& map, const std::string& key, std::size_t item, std::string_view text) {
  const auto* node = map.here().find(key);
  if (node->kind != ConfigNode::Kind::kList || item >= node->items.size()) return map.error(key, text);
  map.errors().add(node->items[item].place, fmt::format("{}.{}[{}]", map.path(), key, item), text);
}

void read_interfaces(ConfigReader& tuples, DdsOptions& dds) {
  const auto names = tuples.texts("interfaces");
  if (!tuples.has("interfaces")) return;
  if (names.empty() || names.size() > tuples::dds::kMaxInterfaces) {
    return tuples.error("interfaces", fmt::format("has {} names, expected 1 to {} names of network interfaces",
                                                  names.size(), tuples::dds::kMaxInterfaces));
  }
  std::set<std::string> taken;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& name = names[i];
    if (name.empty() || name.size() > kMaxInterface || !is_made_of(name, "._-"))
      item_error(tuples, "interfaces", i, "expected the name of a network interface, such as eth0");
    if (!taken.insert(name).second) item_error(tuples, "interfaces", i, fmt::format("'{}' is listed twice", name));
    if (name == kLoopback && names.size() > 1)
      item_error(tuples, "interfaces", i,
                 "lo cannot be combined with others: components of this host use those as well");
  }
  dds.interfaces = names;
}

/// What is wrong with an entry of `peers`; nullptr = nothing.
const char* peer_error(std::string_view peer, bool tcp) {
  const auto colon = peer.find(':');
  const auto host = peer.substr(0, colon);
  if (host.size() > kMaxHostText || !is_made_of(host, ".-") || !base::host_fault(host).empty()) {
    return "expected host or host:port, the host as a name or an IPv4 address";
  }
  if (colon == peer.npos) return tcp ? "expected host:port: over tcp every process has a port of its own" : nullptr;
  const auto port = base::parse_number<std::uint16_t>(peer.substr(colon + 1));
  return port.value_or(0) != 0 ? nullptr : "expected a port from 1 to 65535 after the colon";
}

void read_peers(ConfigReader& tuples, DdsOptions& dds) {
  dds.peers = tuples.texts("peers");
  const bool tcp = dds.transport == DdsTransport::kTcp;
  if (dds.peers.size() > kMaxPeerCount)
    tuples.error("peers", fmt::format("has {} hosts, expected at most {}", dds.peers.size(), kMaxPeerCount));
  for (std::size_t i = 0; i < dds.peers.size(); ++i) {
    if (const auto* wrong = peer_error(dds.peers[i], tcp)) item_error(tuples, "peers", i, wrong);
  }
  if (!dds.peers.empty() && !tcp && is_loopback_only(dds)) tuples.error("peers", kReachesNobody);
}

void read_ways(ConfigReader& tuples, DdsOptions& dds) {
  const bool tcp = tuples.choice("transport", "udp", {"udp", "tcp"}) == "tcp";
  dds.transport = tcp ? DdsTransport::kTcp : DdsTransport::kUdp;
  dds.port = static_cast<std::uint16_t>(tuples.integer("port", 0, 0, 0xffff));
  if (!tcp && tuples.has("port"))
    tuples.error("port", "only transport tcp has this option; the ports of udp follow from domain");
  read_peers(tuples, dds);
  if (tcp && dds.port == 0 && dds.peers.empty())
    tuples.error("transport", "tcp does not discover components by itself, expected port or peers (or both)");
}

void read_domain(ConfigReader& tuples, DdsOptions& dds) {
  dds.domain = static_cast<std::uint32_t>(tuples.integer("domain", dds.domain, 0, tuples::dds::kMaxDomain));
  dds.tag = tuples.text("tag", dds.tag);
  if (dds.tag.size() > kMaxTag || !is_made_of(dds.tag, "._-"))
    tuples.error("tag", fmt::format("expected at most {} of A-Z a-z 0-9 . _ -", kMaxTag));
}

/// What is wrong with a name in `engine`; empty = nothing.
std::string engine_error(const std::string& name, std::set<std::string>& taken) {
  static const std::set<std::string> kAll{"memory", "host", "dds", "mqtt", "peis"};
  if (!kAll.contains(name)) return fmt::format("is '{}', expected one of: memory, host, dds, mqtt, peis", name);
  return taken.insert(name).second ? std::string() : fmt::format("'{}' is listed twice", name);
}

void read_names(ConfigReader& tuples, EngineSetup& engine) {
  const auto names = tuples.texts("engine");
  std::set<std::string> taken;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (const auto wrong = engine_error(names[i], taken); !wrong.empty()) item_error(tuples, "engine", i, wrong);
  }
  if (names.empty()) tuples.error("engine", "expected memory, or one or more of: host, dds, mqtt, peis");
  if (taken.contains("memory") && taken.size() > 1) tuples.error("engine", "memory cannot be combined with others");
  engine.host = !taken.contains("memory");
  engine.dds = taken.contains("dds");
  engine.mqtt = taken.contains("mqtt");
  engine.peis = taken.contains("peis");
}

/// Without names: DDS where a key asks for what only DDS has, MQTT where there is a broker.
void read_engines(ConfigReader& tuples, EngineSetup& engine) {
  if (tuples.has("engine")) {
    read_names(tuples, engine);
  } else {
    const auto keys = {"interfaces", "peers", "transport", "port"};
    engine.dds = std::any_of(keys.begin(), keys.end(), [&](const char* key) { return tuples.has(key); });
    engine.mqtt = tuples.node("mqtt") != nullptr;
  }
  const bool host = tuples.boolean("host", engine.host);
  if (host && !engine.host) tuples.error("host", "memory cannot be combined with others");
  engine.host = host;
  if (!tuples.has("engine") && engine.alone())
    tuples.error("host", "leaves no engine, expected engine too: dds, mqtt, peis, or memory");
}

void read_host(ConfigReader& tuples, EngineSetup& engine) {
  engine.space = tuples.text("space", "");
  engine.folder = tuples.text("folder", "");
  for (const auto* key : {"space", "folder"}) {
    if (tuples.has(key) && !engine.host) tuples.error(key, "only engine host has this option");
  }
  if (!engine.space.empty()) {
    if (const auto good = tuples::host::check_space(engine.space); !good) tuples.error("space", good.error().text);
  }
  if (!engine.folder.empty() && engine.folder.front() != '/')
    tuples.error("folder", fmt::format("is '{}', expected an absolute path", engine.folder));
}

/// A warning about a key, with its place.
void warn(ConfigReader& tuples, const std::string& key, std::string_view text, EngineSetup& engine) {
  engine.warnings.push_back(fmt::format("{}: {}.{}: {}", to_string(tuples.node(key)->place), tuples.path(), key, text));
}

/// Before the engine `host` existed, a domain and a tag divided a host as spaces do now.
void read_old_space(ConfigReader& tuples, DdsOptions& dds, EngineSetup& engine) {
  read_domain(tuples, dds);
  const std::string key = tuples.has("tag") ? "tag" : "domain";
  if (!tuples.has(key)) return;
  const auto space = tuples::host::space_of(dds.domain, dds.tag);
  if (tuples.has("space")) return tuples.error(key, "only engine dds has this option, and there is a space");
  if (const auto good = tuples::host::check_space(space); !good)
    return tuples.error(key, "cannot become a space of this host: " + good.error().text);
  engine.space = space;
  warn(tuples, key, fmt::format("without interfaces this is the space of this host, expected space: {}", space),
       engine);
}

void read_connect(ConfigReader& peis, tuples::peis::PeisOptions& options) {
  auto& connect = options.connect;
  for (const auto& url : peis.texts("connect")) {
    auto target = tuples::peis::connect_target(url);
    if (!target) item_error(peis, "connect", connect.size(), target.error().text);
    if (target && tuples::peis::leaves_loopback(options.interfaces, *target))
      item_error(peis, "connect", connect.size(), kReachesNobody);
    connect.push_back(std::move(target).value_or(url));
  }
  if (connect.size() > kMaxPeerCount)
    peis.error("connect", fmt::format("has {} components, expected at most {}", connect.size(), kMaxPeerCount));
}

/// 0 = the file has none.
std::uint32_t own_id(ConfigReader& root) {
  const auto* island = root.here().find("island");
  const auto* id = island ? island->find("id") : nullptr;
  return id ? base::parse_number<std::uint32_t>(id->text).value_or(0) : 0;
}

/// What it has in common with DDS was read before.
void read_peis(ConfigReader& tuples, std::uint32_t own, EngineSetup& engine) {
  auto& options = engine.peis_options;
  options.interfaces = engine.options.interfaces;
  options.lease = engine.options.lease;
  options.trust_lan = engine.options.trust_lan;
  auto peis = tuples.map("peis");
  options.network = peis.text("network", options.network);
  if (options.network.empty() || options.network.size() > tuples::peis::kMaxNameLength)
    peis.error("network", fmt::format("expected 1 to {} characters", tuples::peis::kMaxNameLength));
  options.listen = static_cast<std::uint16_t>(peis.integer("listen", options.listen, 0, 0xffff));
  options.multicast = peis.boolean("multicast", options.multicast);
  read_connect(peis, options);
  read_carry_of_peis(peis, own, engine);
  peis.finish();
}

void check_keys_of_engines(ConfigReader& tuples, EngineSetup& engine) {
  if (engine.alone() && tuples.has("lease")) tuples.error("lease", "engine memory has no such option");
  if (!engine.mqtt && tuples.node("mqtt")) tuples.error("mqtt", "only engine mqtt has these options");
  if (!engine.peis && tuples.has("peis")) tuples.error("peis", "only engine peis has these options");
  if (engine.dds || engine.peis) return;
  if (tuples.has("interfaces")) tuples.error("interfaces", "only engines dds and peis have this option");
  if (!tuples.has("trust_lan")) return;
  if (tuples.has("engine")) return tuples.error("trust_lan", "only engines dds and peis have this option");
  warn(tuples, "trust_lan", "without interfaces no other host reaches this island: it has no effect", engine);
}

/// Without the engine no option is examined: one error for each is enough.
void refuse_dds(ConfigReader& tuples, bool peis) {
  const std::pair<const char*, const char*> keys[] = {
      {"domain", "peis.network decides which components see each other"},
      {"tag", "peis.network decides which components see each other"},
      {"peers", "peis.connect names other hosts"},
      {"port", "peis.listen is the port"},
      {"transport", "it is always tcp"}};
  for (const auto& [key, instead] : keys) {
    if (tuples.node(key))
      tuples.error(key,
                   fmt::format("only engine dds has this option{}{}", peis ? "; for PEIS " : "", peis ? instead : ""));
  }
}

void read_dds(ConfigReader& tuples, DdsOptions& dds) {
  read_domain(tuples, dds);
  read_ways(tuples, dds);
}

/// `yes`, `no`, or a folder, which has a slash.
void read_trust(ConfigReader& tuples, EngineSetup& engine) {
  if (!tuples.has("trust")) return;
  const auto text = tuples.text("trust", "");
  const auto is = [&text](std::initializer_list<const char*> words) {
    return std::find(words.begin(), words.end(), text) != words.end();
  };
  engine.old_trust = is({"no", "off", "false"}) ? OldTrust::kNo : OldTrust::kYes;
  if (engine.old_trust == OldTrust::kYes && text.find('/') == text.npos && !is({"yes", "on", "true"}))
    tuples.error("trust", fmt::format("is '{}', expected no: this release has no certificates for DDS", text));
}

}  // namespace

EngineSetup read_engine(ConfigReader& root, const std::string& directory) {
  EngineSetup engine;
  auto tuples = root.map("tuples");
  if (root.has("tuples")) {
    const auto* names = tuples.here().find("interfaces");
    engine.place = fmt::format("{}: tuples{}: ", to_string(names ? names->place : tuples.here().place),
                               names ? ".interfaces" : "");
  }
  read_trust(tuples, engine);
  read_engines(tuples, engine);
  read_host(tuples, engine);
  auto& dds = engine.options;
  read_interfaces(tuples, dds);
  if (engine.dds) {
    read_dds(tuples, dds);
  } else if (engine.host && !tuples.has("engine")) {
    read_old_space(tuples, dds, engine);
  } else {
    refuse_dds(tuples, engine.peis);
  }
  dds.lease = tuples.duration("lease", dds.lease);
  if (dds.lease < kMinLeaseTime || dds.lease > kMaxLease) tuples.error("lease", "expected from 500ms to 60s");
  dds.trust_lan = tuples.boolean("trust_lan", dds.trust_lan);
  if (tuples.has("trust_lan")) engine.trust_lan = tuples.node("trust_lan")->place;
  if (engine.mqtt && !tuples.node("mqtt")) {
    tuples.error("engine", "mqtt needs a broker, expected mqtt: {broker: HOST} too");
  } else if (engine.mqtt) {
    engine.mqtt_space = read_mqtt_space(tuples, directory);
  }
  read_carry(tuples, own_id(root), engine);
  read_peis(tuples, own_id(root), engine);
  check_keys_of_engines(tuples, engine);
  static constexpr std::string_view kAll[] = {"engine", "domain", "peers", "port", "transport"};
  tuples.also_known(kAll);
  tuples.finish();
  return engine;
}

}  // namespace rubicon::config
