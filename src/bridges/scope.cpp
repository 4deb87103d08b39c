#include "bridges/scope.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/compare_text.h"

namespace rubicon::bridges {

namespace {

/// What `commands: yes` takes, and what it does not: that opens doors, or ends an alarm.
constexpr const char* kUsualCommands = "*.*.*.actuator.*.command";
constexpr std::string_view kGuarded[] = {"lock",  "lockState", "doorOpener", "garageDoor",
                                         "alarm", "windAlarm", "frostAlarm", "siren"};

bool is_word(const std::vector<std::string>& words, std::string_view word) {
  return words.size() == 1 && words.front() == word;
}

void read_commands(ConfigReader& options, Scope& found) {
  const auto words = options.texts("commands");
  if (words.empty() || is_word(words, "no") || is_word(words, "false")) return;
  if (!is_word(words, "yes") && !is_word(words, "true")) {
    found.commands = read_keys(options, "commands");
    return;
  }
  found.commands = {kUsualCommands};
  for (const auto type : kGuarded) found.forbidden.push_back(fmt::format("*.*.*.actuator.{}-*.command", type));
}

std::string_view next_part(std::string_view& rest) {
  const auto dot = std::min(rest.find('.'), rest.size());
  const auto part = rest.substr(0, dot);
  rest.remove_prefix(std::min(dot + 1, rest.size()));
  return part;
}

}  // namespace

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

void read_scope(ConfigReader& options, Scope& found) {
  for (const auto& text : options.texts("patterns")) {
    auto pattern = Pattern::parse(text);
    if (pattern)
      found.patterns.push_back(std::move(*pattern));
    else
      options.error("patterns", pattern.error().text);
  }
  found.except = read_keys(options, "except");
  read_commands(options, found);
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

bool takes_command(const Scope& scope, std::string_view key) {
  return any_key_matches(scope.commands, key) && !any_key_matches(scope.forbidden, key);
}

}  // namespace rubicon::bridges
