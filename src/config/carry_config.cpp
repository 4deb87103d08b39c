#include "config/engine_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/text.h"

namespace rubicon::config {

namespace {

using tuples::carry::CarryRule;

constexpr std::size_t kMaxCarried = 1000;
constexpr const char* kDds = "dds";

std::vector<std::string> names_of(const EngineSetup& engine) {
  std::vector<std::string> names;
  if (engine.host) names.emplace_back("host");
  if (engine.dds) names.emplace_back(kDds);
  if (engine.mqtt) names.emplace_back("mqtt");
  if (engine.peis) names.emplace_back("peis");
  return names;
}

/// An entry that was read, and where it stands.
struct CarryEntry {
  std::string text;
  base::ConfigPlace place;
  std::string path;
};

void add_carried(CarryRule& rule, const CarryEntry& entry, std::uint32_t own, base::ConfigErrors& errors) {
  if (const auto good = tuples::carry::add_entry(rule, entry.text); !good) {
    errors.add(entry.place, entry.path, good.error().text);
  } else if (own != 0 && base::parse_number<std::uint32_t>(entry.text) == own) {
    errors.add(entry.place, entry.path, fmt::format("{} is this island, which is on all its engines anyway", own));
  }
}

std::string item_path(const ConfigReader& map, const char* key, std::size_t item) {
  return fmt::format("{}.{}[{}]", map.path(), key, item);
}

/// Ids and patterns of a key, which may be one or a list.
std::vector<CarryEntry> entries_of(ConfigReader& map, const char* key) {
  std::vector<CarryEntry> entries;
  const auto texts = map.texts(key);
  const auto* node = map.node(key);
  const bool is_list = node && node->kind == ConfigNode::Kind::kList;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto at = is_list && node->items.size() == texts.size() ? node->items[i].place : node->place;
    entries.push_back({texts[i], at, is_list ? item_path(map, key, i) : fmt::format("{}.{}", map.path(), key)});
  }
  if (node && (entries.empty() || entries.size() > kMaxCarried))
    map.error(key, fmt::format("has {} entries, expected 1 to {} ids of components or patterns of keys", entries.size(),
                               kMaxCarried));
  return entries;
}

std::vector<std::string> engines_of(ConfigReader& way, const char* key, const std::vector<std::string>& all) {
  auto names = way.texts(key);
  for (const auto& name : names) {
    if (std::find(all.begin(), all.end(), name) == all.end())
      way.error(key, fmt::format("is '{}', expected an engine of this island: {}", name, fmt::join(all, ", ")));
  }
  return names;
}

/// `{what: [4711, kitchen.**], from: dds, to: mqtt}`.
CarryRule read_carry_rule(ConfigReader way, std::uint32_t own, const std::vector<std::string>& engines) {
  CarryRule rule;
  if (!way.has("what")) way.error({}, "'what' is missing, expected ids of components or patterns of keys");
  for (const auto& entry : entries_of(way, "what")) add_carried(rule, entry, own, way.errors());
  rule.from = engines_of(way, "from", engines);
  rule.to = engines_of(way, "to", engines);
  if (rule.from.size() == 1 && rule.from == rule.to) way.error("to", "is where it comes from, expected another engine");
  way.finish();
  return rule;
}

}  // namespace

void read_carry(ConfigReader& tuples, std::uint32_t own, EngineSetup& engine) {
  const auto* node = tuples.node("carry");
  if (!node) return;
  const auto engines = names_of(engine);
  if (engines.size() < 2)
    return tuples.error("carry", "needs two engines to carry between, expected engine too, such as [dds, mqtt]");
  engine.carry_path = {"tuples", "carry"};
  CarryRule anywhere;
  const bool is_list = node->kind == ConfigNode::Kind::kList;
  for (std::size_t i = 0; is_list && i < node->items.size(); ++i) {
    const auto& item = node->items[i];
    const auto path = item_path(tuples, "carry", i);
    if (item.kind == ConfigNode::Kind::kScalar) {
      add_carried(anywhere, {item.text, item.place, path}, own, tuples.errors());
    } else {
      engine.carry.rules.push_back(read_carry_rule(ConfigReader(item, path, tuples.errors()), own, engines));
    }
  }
  if (!is_list) {
    for (const auto& entry : entries_of(tuples, "carry")) add_carried(anywhere, entry, own, tuples.errors());
  }
  if (!anywhere.ids.empty() || !anywhere.patterns.empty()) engine.carry.rules.push_back(std::move(anywhere));
  if (is_list && (node->items.empty() || node->items.size() > kMaxCarried))
    tuples.error("carry", fmt::format("has {} entries, expected 1 to {} ids of components, patterns of keys, or maps "
                                      "with what, from and to",
                                      node->items.size(), kMaxCarried));
}

void read_carry_of_peis(ConfigReader& peis, std::uint32_t own, EngineSetup& engine) {
  if (!peis.node("carry")) return;
  if (!engine.carry.empty()) return peis.error("carry", "tuples.carry is there too, expected all of it there");
  if (!engine.dds || !engine.peis)
    return peis.error("carry", "needs two engines to carry between, expected engine: [dds, peis]");
  engine.carry_path = {"tuples", "peis", "carry"};
  CarryRule rule{{}, {}, {kDds, "peis"}, {kDds, "peis"}};
  for (const auto& entry : entries_of(peis, "carry")) add_carried(rule, entry, own, peis.errors());
  engine.carry.rules.push_back(std::move(rule));
}

std::vector<std::string> carried(const tuples::carry::CarryRules& rules) {
  std::vector<std::string> all;
  for (const auto& rule : rules.rules) {
    std::vector<std::string> what;
    for (const auto id : rule.ids) what.push_back(fmt::format("component {}", number(id)));
    for (const auto& keys : rule.patterns) what.push_back(fmt::format("{} of every component", keys));
    const auto among = [](const char* word, const std::vector<std::string>& names) {
      return names.empty() ? std::string() : fmt::format(" {} {}", word, fmt::join(names, " or "));
    };
    all.push_back(fmt::format("{}{}{}", fmt::join(what, ", "), among("from", rule.from), among("to", rule.to)));
  }
  return all;
}

}  // namespace rubicon::config
