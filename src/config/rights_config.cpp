#include "config/rights_config.h"

#include <fmt/format.h>

#include "rights/rights.h"

namespace rubicon::config {

namespace {

using rights::Right;
using rights::RightSet;
using rights::Rule;

constexpr const char* kAll = "all";

RightSet rights_in(ConfigReader& entry) {
  RightSet rights;
  const auto words = entry.texts("may");
  for (const auto& word : words) {
    const auto right = rights::right_of(word);
    if (right) {
      rights.add(*right);
    } else if (word == kAll) {
      rights.add(RightSet::all());
    } else {
      entry.error(
          "may",
          fmt::format("is '{}', expected some of: read, demand, set, approve, send; or all; or vouch alone", word));
    }
  }
  if (words.empty()) entry.error("may", "is missing, expected some of: read, demand, set, approve, send; or all");
  return rights;
}

std::vector<std::string> patterns_of(ConfigReader& entry, const std::string& key) {
  auto patterns = entry.texts(key);
  for (const auto& pattern : patterns) {
    if (const auto good = rights::check_rule_key(pattern); !good) entry.error(key, good.error().text);
  }
  if (entry.has(key) && patterns.empty())
    entry.error(key, "is empty, expected patterns of keys, such as [\"proxy.**\"]");
  return patterns;
}

std::vector<std::string> members_in(ConfigReader& entry) {
  auto who = entry.texts("who");
  for (const auto& word : who) {
    if (const auto good = rights::check_who(word); !good) entry.error("who", good.error().text);
  }
  if (who.empty())
    entry.error("who", "is missing, expected names or roles of members, everybody, lan, peis, or island:<id>");
  return who;
}

void read_interval(ConfigReader& entry, Rule& rule) {
  rule.interval = entry.duration("interval", Duration(0));
  if (!entry.has("interval")) return;
  if (!rule.may.has(Right::kDemand))
    return entry.error("interval", "limits demand, expected a rule with the right to demand");
  if (rule.interval <= Duration(0)) entry.error("interval", "expected more than 0s, the fastest demand");
}

/// `{who: hall, may: vouch, names: ["user:*"]}`.
void read_vouch(ConfigReader& entry, Rule& rule) {
  rule.keys.clear();
  rule.names = entry.texts("names");
  for (const auto& name : rule.names) {
    if (const auto good = rights::check_vouched(name); !good) entry.error("names", good.error().text);
  }
  if (rule.names.empty()) entry.error("names", "is missing, expected the names it vouches for, such as [\"user:*\"]");
  entry.finish();
}

Rule read_rule(ConfigReader& entry) {
  Rule rule;
  rule.place = to_string(entry.here().place);
  rule.who = members_in(entry);
  if (entry.has("may") && entry.texts("may") == std::vector{std::string(rights::kVouch)}) {
    read_vouch(entry, rule);
    return rule;
  }
  rule.may = rights_in(entry);
  rule.keys = patterns_of(entry, "keys");
  rule.except = patterns_of(entry, "not");
  if (!entry.has("keys") && rule.may == RightSet::all()) rule.keys = {"**"};
  if (rule.keys.empty() && !entry.has("keys"))
    entry.error("keys", "is missing, expected patterns of keys, such as [\"proxy.**\"]; only may: all needs none");
  read_interval(entry, rule);
  entry.finish();
  return rule;
}

}  // namespace

std::optional<RightsSetup> read_rights(ConfigReader& root) {
  if (!root.has("rights")) return std::nullopt;
  RightsSetup setup;
  setup.place = root.here().find("rights")->place;
  auto entries = root.list("rights");
  if (entries.size() > kMaxRules)
    root.error("rights", fmt::format("has {} rules, expected at most {}", entries.size(), kMaxRules));
  for (auto& entry : entries) setup.rules.push_back(read_rule(entry));
  return setup;
}

AuditSetup read_audit(ConfigReader& root) {
  auto audit = root.map("audit");
  AuditSetup setup;
  setup.file = audit.text("file", "");
  if (audit.has("file") && setup.file.empty()) audit.error("file", "empty path, expected a file");
  setup.hide = audit.texts("hide");
  for (const auto& key : setup.hide) {
    if (const auto good = rights::check_rule_key(key); !good) audit.error("hide", good.error().text);
  }
  setup.size = audit.size("size", setup.size, kMinAudit);
  audit.finish();
  return setup;
}

}  // namespace rubicon::config
