#include "bridges/mqtt/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/glob.h"
#include "transport/mqtt_topics.h"

namespace rubicon::bridges::mqtt {

namespace {

constexpr std::size_t kMaxBase = 64;
/// What `commands: yes` takes, and what it does not: that opens doors, or ends an alarm.
constexpr const char* kUsualCommands = "*.*.*.actuator.*.command";
constexpr std::string_view kGuarded[] = {"lock",  "lockState", "doorOpener", "garageDoor",
                                         "alarm", "windAlarm", "frostAlarm", "siren"};

std::string base_fault(std::string_view base) {
  if (base.empty() || base.size() > kMaxBase) return "expected 1 to 64 bytes";
  if (base.find_first_of("+#") != base.npos || base.starts_with('/') || base.ends_with('/') ||
      base.find("//") != base.npos)
    return "expected levels joined by /, without + and #";
  if (base.starts_with('$')) return "topics with $ are the broker's own";
  return {};
}

void read_base(ConfigReader& options, Options& found) {
  found.base = options.text("base", found.base);
  auto fault = base_fault(found.base);
  if (found.base == "rubicon-space" || found.base.starts_with("rubicon-space/"))
    fault = "is where components meet at a broker (docs/sites.md)";
  if (found.base.starts_with("homeassistant")) fault = "is where Home Assistant expects announcements";
  if (!fault.empty()) options.error("base", fmt::format("is '{}': {}", found.base, fault));
  found.discovery_base = options.text("discovery-base", found.discovery_base);
  if (const auto wrong = base_fault(found.discovery_base); !wrong.empty()) options.error("discovery-base", wrong);
}

/// Lists of key patterns, or words for usual ones.
std::vector<std::string> read_keys(ConfigReader& options, const std::string& key) {
  auto keys = options.texts(key);
  for (const auto& text : keys) {
    const auto parsed = Pattern::parse(text);
    const bool parts =
        text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.*") == text.npos &&
        !text.empty() && text.find("..") == text.npos;
    if (!parsed && !parts) options.error(key, parsed.error().text);
  }
  return keys;
}

bool is_word(const std::vector<std::string>& words, std::string_view word) {
  return words.size() == 1 && words.front() == word;
}

void read_commands(ConfigReader& options, Options& found) {
  const auto words = options.texts("commands");
  if (words.empty() || is_word(words, "no") || is_word(words, "false")) return;
  if (!is_word(words, "yes") && !is_word(words, "true")) {
    found.commands = read_keys(options, "commands");
    return;
  }
  found.commands = {kUsualCommands};
  for (const auto type : kGuarded) found.forbidden.push_back(fmt::format("*.*.*.actuator.{}-*.command", type));
}

/// `passive`, `on-request`, or {active: [patterns]}.
void read_demand(ConfigReader& options, Options& found) {
  const auto* node = options.node("demand");
  if (node == nullptr) return;
  if (node->kind == ConfigNode::Kind::kMap) {
    auto demand = options.map("demand");
    found.active = read_keys(demand, "active");
    return demand.finish();
  }
  found.on_request = options.choice("demand", "passive", {"passive", "on-request"}) == "on-request";
}

void read_patterns(ConfigReader& options, Options& found) {
  for (const auto& text : options.texts("patterns")) {
    auto pattern = Pattern::parse(text);
    if (pattern)
      found.patterns.push_back(std::move(*pattern));
    else
      options.error("patterns", pattern.error().text);
  }
  found.except = read_keys(options, "except");
}

std::string_view next_part(std::string_view& rest) {
  const auto dot = std::min(rest.find('.'), rest.size());
  const auto part = rest.substr(0, dot);
  rest.remove_prefix(std::min(dot + 1, rest.size()));
  return part;
}

}  // namespace

Options read_options(ConfigReader& options, const std::string& directory) {
  Options found;
  found.broker = transport::read_mqtt_broker(options, directory);
  read_base(options, found);
  read_patterns(options, found);
  read_commands(options, found);
  read_demand(options, found);
  const auto form = options.choice("discovery", "none", {"none", "homeassistant", "homeassistant-entities"});
  found.discovery = form == "none"            ? Discovery::kNone
                    : form == "homeassistant" ? Discovery::kDevices
                                              : Discovery::kEntities;
  found.json = options.choice("payload", "text", {"text", "json"}) == "json";
  found.friendly = options.choice("names", "keys", {"keys", "friendly"}) == "friendly";
  found.keep = options.boolean("keep", false);
  found.page = options.text("page", {});
  if (!found.page.empty() && !found.page.starts_with("http://") && !found.page.starts_with("https://"))
    options.error("page", "expected the address of the page: http://HOST:PORT or https://HOST:PORT");
  if (found.json && found.discovery != Discovery::kNone)
    options.error("payload",
                  "json is for databases, expected text where there is a discovery; a second bridge may "
                  "have the other");
  return found;
}

bool key_matches(std::string_view pattern, std::string_view key) {
  while (!pattern.empty() && !key.empty()) {
    if (pattern == "**") return true;
    if (!base::glob_matches(next_part(pattern), next_part(key))) return false;
  }
  return key.empty() && (pattern.empty() || pattern == "**");
}

bool any_key_matches(const std::vector<std::string>& patterns, std::string_view key) {
  return std::any_of(patterns.begin(), patterns.end(), [key](const auto& one) { return key_matches(one, key); });
}

bool takes_command(const Options& options, std::string_view key) {
  return any_key_matches(options.commands, key) && !any_key_matches(options.forbidden, key);
}

}  // namespace rubicon::bridges::mqtt
