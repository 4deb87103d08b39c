#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "bridges/ros2/names.h"
#include "bridges/ros2/ros2_bridge.h"
#include "model/type_catalogue.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::bridges::ros2 {

namespace {

constexpr std::size_t kMaxPeers = 64;
constexpr Duration kMaxDiagnostics = std::chrono::hours(1);
/// Robots lose us after such a silence.
constexpr int kLeaseSeconds = 5;
constexpr int kAnnounceMs = 2000;

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const auto end = std::min(text.find(separator), text.size());
    if (end > 0) parts.emplace_back(base::trimmed(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

std::uint32_t domain_of(ConfigReader& options, const Environment& environment) {
  if (options.node("domain") != nullptr)
    return static_cast<std::uint32_t>(options.integer("domain", 0, 0, kMaxRosDomain));
  const auto text = environment("ROS_DOMAIN_ID");
  if (text.empty()) return 0;
  const auto id = base::parse_number<std::uint32_t>(text);
  if (!id || *id > kMaxRosDomain)
    options.error("", fmt::format("ROS_DOMAIN_ID of the environment is '{}': expected 0 to {}", text, kMaxRosDomain));
  return std::min(id.value_or(0), kMaxRosDomain);
}

/// ROS_LOCALHOST_ONLY goes before ROS_AUTOMATIC_DISCOVERY_RANGE, as in ROS 2 Jazzy; without both this host only.
void read_range(ConfigReader& options, const Environment& environment, Reach& reach) {
  if (environment("ROS_LOCALHOST_ONLY") == "1") return;
  const auto range = environment("ROS_AUTOMATIC_DISCOVERY_RANGE");
  if (range.empty() || range == "LOCALHOST") return;
  if (range == "OFF") {
    reach.discovers = false;
  } else if (range == "SUBNET" || range == "SYSTEM_DEFAULT") {
    reach.interfaces.clear();
  } else {
    options.error("",
                  fmt::format("ROS_AUTOMATIC_DISCOVERY_RANGE of the environment is '{}': expected SUBNET, LOCALHOST, "
                              "SYSTEM_DEFAULT or OFF",
                              range));
  }
}

Reach read_reach(ConfigReader& options, const Environment& environment) {
  Reach reach;
  reach.domain = domain_of(options, environment);
  if (options.node("interfaces") != nullptr)
    reach.interfaces = options.texts("interfaces");
  else
    read_range(options, environment, reach);
  if (reach.interfaces == std::vector<std::string>{"any"}) reach.interfaces.clear();
  if (reach.interfaces.size() > tuples::dds::kMaxInterfaces)
    options.error("interfaces", fmt::format("expected at most {}, or any", tuples::dds::kMaxInterfaces));
  reach.peers = options.node("peers") != nullptr ? options.texts("peers") : split(environment("ROS_STATIC_PEERS"), ';');
  if (reach.peers.size() > kMaxPeers) options.error("peers", fmt::format("expected at most {}", kMaxPeers));
  for (const auto& peer : reach.peers) {
    const auto colon = std::min(peer.find(':'), peer.size());
    if (const auto fault = base::host_fault(peer.substr(0, colon)); !fault.empty())
      options.error("peers", fmt::format("'{}': {}", peer, fault));
  }
  reach.cyclone = environment("CYCLONEDDS_URI");
  return reach;
}

/// `robot`, or `robot.battery-1`.
void read_place(ConfigReader& entry, ImportRule& rule) {
  const auto as = entry.text("as", import_place(rule.topic).device);
  const auto dot = std::min(as.find('.'), as.size());
  rule.device = as.substr(0, dot);
  rule.id = as.substr(std::min(dot + 1, as.size()));
  const auto is_part = [](const std::string& text) { return model::to_key_part(text) == text; };
  const bool has_id = dot < as.size();
  if (!is_part(rule.device) || (has_id && !is_part(rule.id)))
    return entry.error("as", "expected DEVICE or DEVICE.TYPE-INSTANCE, such as robot.battery-1");
  rule.type = entry.text("type", has_id ? std::string_view(rule.id).substr(0, rule.id.find('-')) : "");
  rule.part = entry.text("part", "");
  static const model::TypeCatalogue kTypes;
  if (!rule.type.empty() && kTypes.find(rule.type) == nullptr)
    entry.error(entry.has("type") ? "type" : "as", model::unknown_type_text(kTypes, rule.type));
  if (!has_id && !(rule.type.empty() && rule.part.empty()))
    entry.error("as", "expected DEVICE.TYPE-INSTANCE where `type` or `part` choose one value");
}

void read_imports(ConfigReader& options, Options& found) {
  const auto* node = options.node("import");
  if (node == nullptr) return;
  if (node->kind == ConfigNode::Kind::kScalar) {
    found.imports_all = options.choice("import", "no", {"auto", "no"}) == "auto";
    return;
  }
  for (auto& entry : options.list("import")) {
    ImportRule rule;
    rule.topic = entry.required_text("topic", "the name of a ROS topic");
    if (!rule.topic.empty() && !is_ros_name(rule.topic))
      entry.error("topic", "expected an absolute name, such as /battery_state");
    read_place(entry, rule);
    entry.finish();
    found.imports.push_back(std::move(rule));
  }
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&' || c == '"') continue;  // none of them is part of a name or an address
    out += c;
  }
  return out;
}

/// The ports of the last process of a domain are below 65536.
unsigned max_index(std::uint32_t domain) {
  return std::min(tuples::dds::kMaxProcessesPerHost, (65535U - 1 - tuples::dds::port_of(domain, 0)) / 2);
}

std::string peer_elements(const Reach& reach) {
  std::string out;
  const auto add = [&out](const std::string& address) {
    out += fmt::format("<Peer address=\"{}\"/>", escaped(address));
  };
  // Where multicast does not work on loopback, the first processes of the host find each other.
  if (reach.interfaces == std::vector<std::string>{"lo"}) {
    for (unsigned i = 0; i < tuples::dds::kProcessesSearchedOnPeer; ++i)
      add(fmt::format("127.0.0.1:{}", tuples::dds::port_of(reach.domain, i)));
  }
  for (const auto& peer : reach.peers) add(peer);
  return out;
}

}  // namespace

Options read_options(ConfigReader& options, const Environment& environment) {
  Options found;
  found.origin = "ros-domain";
  read_scope(options, found);
  found.reach = read_reach(options, environment);
  found.name_space = options.text("namespace", "");
  if (found.name_space != "" && !is_ros_name("/" + found.name_space + "/x"))
    options.error("namespace", "expected letters, digits and _, not beginning with a digit");
  const auto distribution = options.choice("distribution", "auto", {"auto", "humble", "jazzy", "none"});
  found.distribution = distribution == "humble"  ? Distribution::kHumble
                       : distribution == "jazzy" ? Distribution::kJazzy
                       : distribution == "none"  ? Distribution::kNone
                                                 : Distribution::kAuto;
  found.diagnostics = options.duration_or_never("diagnostics", found.diagnostics).value_or(Duration(0));
  if (found.diagnostics != Duration(0) &&
      (found.diagnostics < std::chrono::milliseconds(100) || found.diagnostics > kMaxDiagnostics))
    options.error("diagnostics", "expected 100ms to 1h, or never");
  read_imports(options, found);
  return found;
}

/// Buffers and bounds as in tuples/dds/dds_options.cpp, which says why.
std::string domain_xml(const Reach& reach) {
  std::string interfaces;
  for (const auto& name : reach.interfaces)
    interfaces += fmt::format("<NetworkInterface name=\"{}\" multicast=\"true\"/>", escaped(name));
  if (!interfaces.empty()) interfaces = "<Interfaces>" + interfaces + "</Interfaces>";
  const bool is_host = reach.interfaces == std::vector<std::string>{"lo"};
  return fmt::format(
      "<CycloneDDS xmlns=\"https://cdds.io/config\"><Domain Id=\"any\">"
      "<General>{}<AllowMulticast>{}</AllowMulticast></General>"
      "<Internal><MaxSampleSize>4 MiB</MaxSampleSize><WriterLingerDuration>0 s</WriterLingerDuration>{}</Internal>"
      "<Sizing><ReceiveBufferSize>66 KiB</ReceiveBufferSize><ReceiveBufferChunkSize>66 KiB</ReceiveBufferChunkSize>"
      "</Sizing>"
      "<Discovery><ExternalDomainId>{}</ExternalDomainId><ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex><Peers>{}</Peers><LeaseDuration>{} s</LeaseDuration>"
      "<SPDPInterval>{} ms</SPDPInterval></Discovery></Domain></CycloneDDS>{}",
      interfaces,
      !reach.discovers ? "false"
      : is_host        ? "spdp"
                       : "true",
      is_host ? "" : "<MultipleReceiveThreads>false</MultipleReceiveThreads>", reach.domain, max_index(reach.domain),
      reach.discovers ? peer_elements(reach) : "", kLeaseSeconds, kAnnounceMs,
      reach.cyclone.empty() ? "" : "," + reach.cyclone);
}

}  // namespace rubicon::bridges::ros2
