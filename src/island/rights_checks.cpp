#include "island/rights_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>

#include "base/compare_text.h"
#include "base/text.h"
#include "config/engine_config.h"
#include "island/island_state.h"
#include "model/point_keys.h"

namespace rubicon::island {

namespace {

using rights::Right;
using rights::Rule;

bool is_among(const std::vector<std::string>& all, std::string_view one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

/// The part of the key that names a network, as a pattern; empty: any, or none.
std::string_view network_part(std::string_view key, const Rule& rule, std::string_view prefix) {
  const auto first = key.substr(0, key.find('.'));
  if (rule.may.has(Right::kSend) && first != prefix) return first.starts_with("island:") || first == "own" ? "" : first;
  if (first != prefix || first.size() == key.size()) return {};
  const auto rest = key.substr(first.size() + 1);
  // `proxy.settings`, `proxy.recorder.x`: tuples of the island itself
  return model::is_part_of_island(rest.substr(0, rest.find('.'))) ? std::string_view() : rest.substr(0, rest.find('.'));
}

bool names_a_network(std::string_view pattern, const IslandConfig& config) {
  if (pattern.empty() || pattern == "**") return true;
  return std::any_of(config.networks.begin(), config.networks.end(),
                     [&](const auto& setup) { return base::glob_matches(pattern, setup.id); });
}

/// Names that no member and no token has.
std::vector<std::string> strangers(const Rule& rule, const std::vector<std::string>& names) {
  std::vector<std::string> unknown;
  for (const auto& word : rule.who) {
    const bool special = word == rights::kEverybody || word == tuples::kPeisMember || word == tuples::kLanMember ||
                         word.starts_with(rights::kIsland);
    const bool of_host =
        word.starts_with(rights::kUser) || word.starts_with(rights::kGroup) || word.starts_with(rights::kBridge);
    auto name = word;
    for (const auto source : {rights::kMember, rights::kRole}) {
      if (name.starts_with(source)) name.erase(0, source.size());
    }
    const bool is_vouched_for = word.find('@') != word.npos;  // of another host: only who vouches knows it
    if (!special && !of_host && !is_vouched_for && !is_among(names, name)) unknown.push_back(word);
  }
  return unknown;
}

/// How rules name users of the host, where that may be meant.
std::string user_hint(const std::vector<std::string>& names) {
  const auto plain =
      std::find_if(names.begin(), names.end(), [](const auto& name) { return name.find(':') == name.npos; });
  return plain == names.end() ? std::string() : fmt::format("; a user of this host is user:{}", *plain);
}

void warn_of_keys(const Rule& rule, const IslandConfig& config, std::vector<std::string>& lines) {
  for (const auto& key : rule.keys) {
    const auto part = network_part(key, rule, config.proxy.prefix);
    if (!names_a_network(part, config)) {
      lines.push_back(
          fmt::format("{}: keys: '{}' matches nothing: the island has no network '{}'", rule.place, key, part));
    } else if (is_among(rule.except, key)) {
      lines.push_back(fmt::format("{}: keys: '{}' stands in `not` too: the rule denies it", rule.place, key));
    }
  }
}

}  // namespace

rights::Rights rights_of(const IslandConfig& config) {
  return config.rights ? rights::Rights(config.rights->rules) : rights::Rights();
}

std::shared_ptr<rights::RightsJudge> make_judge(const IslandConfig& config) {
  const bool has_realm = config.engine.mqtt && !config.engine.mqtt_space.realm_folder().empty();
  if (!config.rights && !has_realm) return nullptr;
  std::vector<std::string> operators{"user:0", fmt::format("user:{}", ::geteuid())};
  return std::make_shared<rights::RightsJudge>(rights_of(config), nullptr, config.proxy.prefix, std::move(operators));
}

rights::AuditOptions audit_options(const IslandConfig& config) {
  const auto& audit = config.audit;
  const auto state = state_path(config);
  const auto beside_state = state.empty() ? state : state + ".audit";
  return {audit.file.empty() ? beside_state : base::resolve_path(config.directory, audit.file), audit.hide, audit.size};
}

void check_rights(const IslandConfig& config, base::ConfigErrors& errors) {
  if (!config.rights || !config.engine.trust_lan) return;
  errors.add(*config.engine.trust_lan, "tuples.trust_lan",
             "with rights the rules for lan and peis say what components of other hosts may do, expected one of them");
}

std::vector<std::string> rights_warnings(const IslandConfig& config,
                                         const std::optional<std::vector<std::string>>& names) {
  std::vector<std::string> lines;
  if (!config.rights) return lines;
  const std::pair<std::string_view, bool> wires[] = {{tuples::kLanMember, config.engine.dds},
                                                     {tuples::kPeisMember, config.engine.peis}};
  for (const auto& rule : config.rights->rules) {
    const auto unknown = names ? strangers(rule, *names) : std::vector<std::string>();
    if (!unknown.empty()) {
      lines.push_back(fmt::format("{}: who: no member and no token has the name or role {}{}", rule.place,
                                  fmt::join(unknown, ", "), user_hint(unknown)));
    }
    for (const auto& [wire, is_on] : wires) {
      if (is_among(rule.who, wire) && !is_on)
        lines.push_back(
            fmt::format("{}: who: {} matches no component: the island is not on that engine", rule.place, wire));
    }
    warn_of_keys(rule, config, lines);
  }
  for (const auto& [wire, is_on] : wires) {
    if (is_on)
      lines.push_back(
          fmt::format("{0}: rights: a component on {1} proves nothing: all that reach that network are `{2}`, and "
                      "have the rights of `{2}`",
                      to_string(config.rights->place), wire == tuples::kLanMember ? "DDS" : "PEIS", wire));
  }
  return lines;
}

}  // namespace rubicon::island
