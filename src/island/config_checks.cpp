#include "island/config_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>
#include <unordered_map>

#include "base/compare_text.h"
#include "base/text.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::island {

namespace {

/// Comparing each wrong address with all others takes time, so suggestions stop after this number of mistakes.
constexpr std::size_t kMaxNamedEntries = 50;

proxy::LostName lost_device(const std::string& address, const std::vector<network::ListedDevice>& listed) {
  std::vector<std::string> addresses;
  for (const auto& device : listed) addresses.push_back(device.address);
  const auto near = base::did_you_mean(address, addresses);
  return {{address}, fmt::format("the network has no such device{}", near.empty() ? "" : "; " + near)};
}

}  // namespace

std::vector<proxy::LostName> lost_names(const proxy::NetworkRules& rules,
                                        const std::optional<std::vector<network::ListedDevice>>& listed,
                                        const TypeCatalogue& types) {
  std::vector<proxy::LostName> out;
  if (!listed) return out;
  std::unordered_map<std::string_view, const network::ListedDevice*> by_address;
  for (const auto& device : *listed) by_address.emplace(device.address, &device);
  for (const auto& [address, names] : rules.devices) {
    if (out.size() >= kMaxNamedEntries) break;
    const auto device = by_address.find(address);
    if (device == by_address.end()) {
      out.push_back(lost_device(address, *listed));
      continue;
    }
    std::vector<std::string> sensors, actuators;
    for (const auto& capability : device->second->capabilities) {
      if (capability.point.kind == Kind::kProperty) continue;
      auto& ids = capability.point.kind == Kind::kSensor ? sensors : actuators;
      ids.push_back(proxy::point_id(nullptr, capability, types.find(capability.point.type)));
    }
    for (auto& lost : proxy::lost_names(names, sensors, actuators)) {
      lost.path.insert(lost.path.begin(), address);
      out.push_back(std::move(lost));
    }
  }
  return out;
}

namespace {

using networks::wsn::sink::Source;

/// The device of a network whose `source` is a serial line, whatever link leads there; empty = it has none.
std::string serial_device(const ConfigNode& source) {
  const auto read = networks::wsn::sink::parse_source(source.text);
  if (!read || read->kind != Source::Kind::kSerial) return {};
  std::error_code unknown;
  const auto device = std::filesystem::weakly_canonical(read->path, unknown);
  return unknown ? read->path : device.string();
}

}  // namespace

void check_serial_lines(const IslandConfig& config, base::ConfigErrors& errors) {
  struct User {
    std::string network;
    ConfigPlace place;
  };
  std::map<std::string, User> users;
  for (const auto& setup : config.networks) {
    const auto* source = setup.options.find("source");
    const auto device = source == nullptr ? std::string() : serial_device(*source);
    if (device.empty()) continue;
    const auto [first, fresh] = users.try_emplace(device, User{setup.key, source->place});
    if (fresh) continue;
    errors.add(source->place, fmt::format("networks.{}.source", setup.key),
               fmt::format("{} is the serial line of network {} too ({}), expected a device of its own", device,
                           first->second.network, to_string(first->second.place)));
  }
}

namespace {

/// An option that opens a port.
struct PortUse {
  enum class Protocol : std::uint8_t { kTcp, kUdp };
  Protocol protocol;
  std::string path;
  base::HostPort at;  ///< an empty host is any address
  ConfigPlace place;

  bool meets(const PortUse& other) const {
    return protocol == other.protocol && at.port == other.at.port &&
           (is_any() || other.is_any() || at.host == other.at.host);
  }
  bool is_any() const { return at.host.empty() || at.host == "0.0.0.0" || at.host == "::"; }
};

/// What is no port, or is any free one, is left to who reads the option.
class PortUses {
 public:
  explicit PortUses(base::ConfigErrors& errors) : errors_(errors) {}

  /// `PORT` at `host`, or `HOST:PORT`.
  void add(PortUse::Protocol protocol, const std::string& path, const ConfigNode* node, const char* host) {
    if (node == nullptr) return;
    const auto alone = base::parse_number<std::uint16_t>(node->text);
    const auto at = alone ? base::HostPort{host, *alone} : base::parse_host_port(node->text).value_or(base::HostPort{});
    if (at.port == 0) return;
    const PortUse use{protocol, path, at, node->place};
    const auto first = std::find_if(uses_.begin(), uses_.end(), [&](const PortUse& one) { return one.meets(use); });
    if (first == uses_.end()) return uses_.push_back(use);
    errors_.add(use.place, path,
                fmt::format("{} is the {} port of {} too ({}), expected a port of its own", at.port,
                            protocol == PortUse::Protocol::kTcp ? "TCP" : "UDP", first->path, to_string(first->place)));
  }

 private:
  base::ConfigErrors& errors_;
  std::vector<PortUse> uses_;
};

const ConfigNode* option_in(const ConfigNode& tree, std::string_view name) {
  return tree.kind == ConfigNode::Kind::kMap ? tree.find(name) : nullptr;
}

}  // namespace

void check_ports(const ConfigNode& root, base::ConfigErrors& errors) {
  constexpr auto kLoopback = "127.0.0.1";
  PortUses uses(errors);
  const auto at = [&](const char* section, const char* option, const char* host) {
    if (const auto* tree = option_in(root, section))
      uses.add(PortUse::Protocol::kTcp, fmt::format("{}.{}", section, option), option_in(*tree, option), host);
  };
  at("tuples", "port", "");
  at("web", "listen", kLoopback);
  const auto* networks = option_in(root, "networks");
  if (networks == nullptr || networks->kind != ConfigNode::Kind::kMap) return;
  for (const auto& [key, network] : networks->entries) {
    const auto path = [&key = key](const char* option) { return fmt::format("networks.{}.{}", key, option); };
    uses.add(PortUse::Protocol::kTcp, path("share"), option_in(network, "share"), kLoopback);
    const auto* via = option_in(network, "via");
    if (via == nullptr || via->text == "tunnel")
      uses.add(PortUse::Protocol::kUdp, path("local-port"), option_in(network, "local-port"), "");
  }
}

}  // namespace rubicon::island
