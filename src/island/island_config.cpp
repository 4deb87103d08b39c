#include "island/island_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "base/compare_text.h"
#include "base/text.h"
#include "config/config_file.h"
#include "config/yaml.h"
#include "island/island_commands.h"
#include "model/point_keys.h"
#include "model/type_names.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

Result<OwnTuple> read_one(const std::string& text, std::string_view prefix) {
  const auto wrong = [&text](std::string_view why) {
    return fail(ErrorCode::kInvalid, fmt::format("--tuple {}: {}", model::quoted(text), why));
  };
  const auto equals = text.find('=');
  if (equals == text.npos) return wrong("expected KEY=VALUE");
  OwnTuple tuple{text.substr(0, equals), text.substr(equals + 1)};
  if (const auto good = model::check_key(tuple.key); !good) return wrong(good.error().text);
  const auto first = model::key_parts(tuple.key).front();
  if (first == prefix || first == "GATEWAY" || first == "RUBICON_GATEWAY" || first == "ROAMING")
    return wrong(fmt::format("the island keeps the tuples of {} itself", first));
  return tuple;
}

}  // namespace

Result<std::vector<OwnTuple>> read_own_tuples(const std::vector<std::string>& texts, std::string_view prefix) {
  std::vector<OwnTuple> tuples;
  std::set<std::string> keys;
  for (const auto& text : texts) {
    auto tuple = read_one(text, prefix);
    if (!tuple) return fail(std::move(tuple.error()));
    if (!keys.insert(tuple->key).second)
      return fail(ErrorCode::kInvalid, fmt::format("--tuple {}: its key is given twice", model::quoted(text)));
    tuples.push_back(std::move(*tuple));
  }
  return tuples;
}

void OwnTuples::start() {
  for (const auto& tuple : tuples_) {
    judges_.push_back(space_.add_policy({space_.self(), tuple.key},
                                        [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); }));
    std::ignore = space_.set(tuple.key, tuple.value, {"text/plain"});
  }
}

namespace {

using base::ConfigErrors;

constexpr std::uint64_t kMinState = 1 << 20;

void read_island(ConfigReader& root, IslandConfig& config) {
  auto island = root.map("island");
  if (!root.has("island")) root.error("", "'island' is missing, expected island: {id: 1..65532, name: ...}");
  if (root.has("island") && !island.has("id")) island.error("", "'id' is missing, expected 1..65532");
  config.id = OwnerId(static_cast<std::uint32_t>(island.integer("id", 1, 1, model::kMaxIslandId)));
  config.proxy.island_name = island.text("name", "island");
  config.proxy.prefix = island.text("prefix", "proxy");
  if (config.proxy.prefix != model::to_key_part(config.proxy.prefix)) {
    island.error("prefix", "expected one key part: [A-Za-z0-9_-]+, at most 64 characters");
  }
  island.finish();
}

/// A duration that must not be zero.
Duration positive(ConfigReader& map, const std::string& key, Duration otherwise) {
  const auto span = map.duration(key, otherwise);
  if (span > Duration(0)) return span;
  map.error(key, "expected more than 0s");
  return otherwise;
}

proxy::DiscoveryAction discovery_action(ConfigReader& map, std::string_view otherwise) {
  const auto word = map.choice("new-devices", otherwise, {"auto", "ask", "ignore"});
  for (const auto one : {proxy::DiscoveryAction::kAsk, proxy::DiscoveryAction::kIgnore}) {
    if (to_string(one) == word) return one;
  }
  return proxy::DiscoveryAction::kAuto;
}

void read_discovery(ConfigReader& root, proxy::DiscoveryRules& rules) {
  auto discovery = root.map("discovery");
  rules.otherwise = discovery_action(discovery, "auto");
  for (auto& rule : discovery.list("rules")) {
    proxy::DiscoveryRule read{rule.text("network", ""), rule.text("type", ""), rule.text("address", "")};
    if (!rule.has("new-devices")) rule.error("", "'new-devices' is missing, expected one of: auto, ask, ignore");
    read.action = discovery_action(rule, "auto");
    rules.rules.push_back(std::move(read));
    rule.finish();
  }
  discovery.finish();
}

void read_state(ConfigReader& root, IslandConfig& config) {
  auto state = root.map("state");
  if (root.has("state")) config.state.file = state.required_text("file", "the file that remembers, such as home.state");
  config.state.max_bytes = state.size("size", config.state.max_bytes);
  if (config.state.max_bytes < kMinState) state.error("size", "expected at least 1MB");
  config.proxy.save_period = positive(state, "save-every", config.proxy.save_period);
  state.finish();
}

void read_general(ConfigReader& root, IslandConfig& config) {
  config.engine = config::read_engine(root, config.directory);
  read_discovery(root, config.proxy.discovery);
  read_state(root, config);
  auto limits = root.map("limits");
  config.limits.queue = static_cast<std::size_t>(limits.integer("queue", 10000, 1, 10'000'000));
  config.limits.devices = static_cast<std::size_t>(limits.integer("devices", 20000, 1, 1'000'000));
  config.proxy.max_devices = config.limits.devices;
  limits.finish();
  auto commands = root.map("commands");
  config.proxy.command_time_to_live = positive(commands, "time-to-live", config.proxy.command_time_to_live);
  config.proxy.confirmation_wait = positive(commands, "confirmation-wait", config.proxy.confirmation_wait);
  config.proxy.queue_expiry = positive(commands, "queue-expiry", config.proxy.queue_expiry);
  commands.finish();
}

/// `light-1: window`: default ids to instance names.
std::map<std::string, std::string> read_names(ConfigReader& device, const std::string& key) {
  std::map<std::string, std::string> names;
  std::set<std::string> taken;
  const auto map = device.map(key);
  for (const auto& [from, node] : map.here().entries) {
    const auto wrong = [&, &key = from, &at = node.place](std::string_view text) {
      device.errors().add(at, fmt::format("{}.{}", map.path(), key), text);
    };
    const auto id = model::current_id(from);
    const auto dash = id.rfind('-');
    if (node.text.empty() || node.text != model::to_key_part(node.text)) wrong("expected a name of [A-Za-z0-9_-]+");
    if (dash == id.npos) wrong("expected a sensor or actuator id such as light-1");
    if (!taken.insert(id.substr(0, dash) + "-" + node.text).second) wrong("two of one type get the same name");
    if (!names.emplace(id, node.text).second) wrong(fmt::format("{} has a name already", id));
  }
  return names;
}

proxy::Valid read_rules(ConfigReader& map) {
  proxy::Valid rules;
  const auto number = [&map](const char* key) {
    const auto value = map.real(key, 0);
    return map.has(key) ? std::optional(value) : std::nullopt;
  };
  rules.minimum = number("minimum");
  rules.maximum = number("maximum");
  rules.step = number("step");
  rules.rises = map.boolean("rises", false);
  const auto codes = map.texts("not");
  if (map.has("not")) rules.never.emplace();
  for (const auto& text : codes) {
    const auto code = base::parse_number<double>(text);
    code ? rules.never->push_back(*code) : map.error("not", fmt::format("'{}' is not a number", text));
  }
  if (rules.minimum && rules.maximum && *rules.minimum > *rules.maximum)
    map.error("minimum", fmt::format("is {}, expected at most the maximum {}", *rules.minimum, *rules.maximum));
  if (rules.step && *rules.step <= 0) map.error("step", "expected more than 0");
  map.finish();
  return rules;
}

bool is_number(const model::Type& type) {
  return type.data == model::DataType::kReal || type.data == model::DataType::kInteger;
}

/// `valid:` of a network by type, of a device by default ids.
std::map<std::string, proxy::Valid> read_valid(ConfigReader& parent, bool by_type, const model::TypeCatalogue& types) {
  std::map<std::string, proxy::Valid> valid;
  for (auto& [key, map] : parent.maps("valid")) {
    const auto id = by_type ? std::string(model::current_type(key)) : model::current_id(key);
    const auto dash = id.rfind('-');
    const auto* type = types.find(id.substr(0, dash));
    if (by_type && !type) map.error("", "is not a type, expected one such as temperature (`rubicon types`)");
    if (!by_type && dash == id.npos) map.error("", "expected a sensor or actuator id such as light-1");
    if (type && !is_number(*type))
      map.error("", fmt::format("{} is not a number: its values have no limits", type->name));
    if (!valid.emplace(id, read_rules(map)).second) map.error("", fmt::format("{} has rules already", id));
  }
  return valid;
}

void read_devices(ConfigReader& network, proxy::NetworkRules& rules, const model::TypeCatalogue& types,
                  std::map<std::string, ConfigPlace>& places) {
  std::map<std::string, std::string> addresses;  // by key part
  for (auto& [address, device] : network.maps("devices")) {
    proxy::DeviceNames names;
    names.id = device.text("id", "");
    names.name = device.text("name", "");
    names.area = device.text("area", "");
    names.sensors = read_names(device, "sensors");
    names.actuators = read_names(device, "actuators");
    names.valid = read_valid(device, false, types);
    device.finish();
    if (!names.id.empty() && names.id != model::to_key_part(names.id)) {
      device.error("id", "expected one key part: [A-Za-z0-9_-]+, at most 64 characters");
    }
    const auto part = names.id.empty() ? model::to_key_part(address) : names.id;
    const auto [taken, fresh] = addresses.emplace(part, address);
    if (!fresh) device.error("", fmt::format("its id '{}' is taken by device '{}'", part, taken->second));
    rules.devices.emplace(address, std::move(names));
    places.emplace(address, device.here().key_place());
  }
}

/// Sections that are read only where they stand.
constexpr std::string_view kSections[] = {"web", "history", "rights", "audit", "recorders", "bridges"};

const network::NetworkType* find_type(std::span<const network::NetworkType> types, std::string_view name) {
  const auto found = std::find_if(types.begin(), types.end(), [name](const auto& type) { return type.name == name; });
  return found == types.end() ? nullptr : &*found;
}

std::string type_names(std::span<const network::NetworkType> types) {
  std::vector<std::string_view> names;
  for (const auto& type : types) names.push_back(type.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// `as: wsn-1`: a recording plays under the network id it was recorded under.
std::string played_id(const std::string& key, ConfigReader& network, const std::string& type) {
  if (!network.has("as")) return key;
  auto id = network.text("as", key);
  if (type != "log") network.error("as", "only a network of type log plays another one");
  if (model::is_part_of_island(id)) {
    network.error("as", fmt::format("the tuples of {} are the island's own, expected another id", id));
    return key;
  }
  if (id == model::to_key_part(id)) return id;
  network.error("as", "a network id has [A-Za-z0-9_-]+, at most 64 characters");
  return key;
}

/// `roaming: lab`; empty = off. A word that means yes or no is not the name of a domain.
std::string roaming_domain(ConfigReader& network, std::string_view of_type) {
  auto domain = network.text("roaming", of_type);
  if (domain == "off") return {};
  const auto is = [&domain](std::string_view word) { return domain == word; };
  const bool part = domain.empty() ? !network.has("roaming") : domain == model::to_key_part(domain);
  if (part && !is("on") && !is("yes") && !is("no") && !is("true") && !is("false")) return domain;
  network.error("roaming", "expected off, or the name of a domain: [A-Za-z0-9_-]+, at most 64 characters");
  return {};
}

/// `rate`, which D1.4's text calls sampling-rate.
void read_rate(ConfigReader& network, proxy::NetworkRules& rules) {
  const std::string alias(model::kSamplingRate);
  const bool has_alias = network.has(alias);
  if (has_alias && network.has("rate")) network.error(alias, "is another name of rate, which stands here too");
  const std::string key = has_alias ? alias : "rate";
  rules.rate = std::chrono::duration_cast<std::chrono::milliseconds>(network.duration(key, rules.rate));
  if (rules.rate < std::chrono::milliseconds(1)) network.error(key, "expected at least 1ms");
}

void read_network(const std::string& key, ConfigReader& network, std::span<const network::NetworkType> types,
                  IslandConfig& config) {
  NetworkSetup setup{.id = {}, .key = key};
  proxy::NetworkRules rules;
  const auto type = network.required_text("type", "one of: " + type_names(types));
  setup.type = find_type(types, type);
  if (!setup.type && !type.empty()) {
    std::vector<std::string> names;
    for (const auto& one : types) names.emplace_back(one.name);
    const auto near = base::did_you_mean(type, names);
    network.error("type", fmt::format("is '{}'{} expected one of: {}", type, near.empty() ? "," : "; " + near,
                                      type_names(types)));
  }
  setup.id = played_id(key, network, type);
  if (key != model::to_key_part(key)) network.error("", "a network id has [A-Za-z0-9_-]+, at most 64 characters");
  if (setup.type && key != type && !key.starts_with(type + "-")) {
    network.error("", fmt::format("a network of type {} is called {} or {}-<name>", type, type, type));
  }
  if (setup.type && setup.type->quiet) rules.silence.reset();
  rules.silence = network.duration_or_never("silence", rules.silence);
  if (rules.silence == Duration(0)) network.error("silence", "expected more than 0s, or never");
  read_rate(network, rules);
  rules.roaming = roaming_domain(network, setup.type ? setup.type->roaming : std::string_view());
  rules.lists_devices = setup.type && setup.type->lists_devices;
  rules.discovers = setup.type && setup.type->discovers;
  rules.probes = setup.type && setup.type->probes;
  rules.unique_names = setup.type && setup.type->unique_names;
  if (setup.type) rules.answer_time = setup.type->answer_time;
  rules.valid = read_valid(network, true, config.types);
  read_devices(network, rules, config.types, config.device_places[setup.id]);
  if (!config.proxy.networks.emplace(setup.id, std::move(rules)).second) {
    network.error(network.has("as") ? "as" : "", fmt::format("the network id '{}' is taken", setup.id));
  }
  config.networks.push_back(std::move(setup));
}

/// Each network gets its part of the tree, without the common keys: it may be large, and is needed once.
void hand_out_options(ConfigNode& root, std::vector<NetworkSetup>& networks) {
  auto* all = root.find("networks");
  if (!all) return;
  for (auto& setup : networks) {
    auto* network = all->find(setup.key);
    setup.options = std::move(*network);
    std::erase_if(setup.options.entries, [](const auto& entry) {
      return std::find(std::begin(kCommonNetworkKeys), std::end(kCommonNetworkKeys), entry.first) !=
             std::end(kCommonNetworkKeys);
    });
  }
}

}  // namespace

void NetworkSetup::release_options() {
  kept = base::packed(options);
  options = {};
}

std::vector<std::string> differences(const NetworkSetup& before, const NetworkSetup& now, std::size_t limit) {
  const auto text = [](const NetworkSetup& setup) {
    return setup.kept.empty() ? base::packed(setup.options) : setup.kept;
  };
  const auto old_text = text(before), new_text = text(now);
  if (old_text == new_text) return {};
  return base::differences(base::unpacked(old_text), base::unpacked(new_text), limit);
}

IslandConfig read_island_config(ConfigNode root_node, std::span<const network::NetworkType> types,
                                ConfigErrors& errors) {
  IslandConfig config;
  config::number_networks(root_node);
  config.shown = config::yaml_text(root_node, SettingsTuples::kMaxTextCount);
  ConfigReader root(root_node, "", errors);
  read_island(root, config);
  read_general(root, config);
  config::read_site_types(root, config.types);
  for (auto& [key, network] : root.maps("networks")) read_network(key, network, types, config);
  config.recorders = config::read_recorders(root);
  config.bridges = config::read_bridges(root);
  config.web = config::read_web(root);
  config.history = config::read_history(root);
  config.rights = config::read_rights(root);
  config.audit = config::read_audit(root);
  root.also_known(kSections);
  root.finish();
  for (const auto* section : {"island", "tuples", "types", "state"}) {
    const auto* node = std::as_const(root_node).find(section);
    config.fixed.emplace_back(section, node ? *node : ConfigNode());
  }
  hand_out_options(root_node, config.networks);
  return config;
}

}  // namespace rubicon::island
