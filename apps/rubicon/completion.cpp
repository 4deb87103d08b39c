#include "apps/rubicon/completion.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::cli {

namespace {

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// The innermost one: `knx`, then `knx read`.
const CLI::App* subcommand_in(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* found = nullptr;
  for (const auto& word : words) {
    for (const auto* sub : subcommands_of(found ? *found : app)) {
      if (sub->get_name() != word) continue;
      found = sub;
      break;
    }
  }
  return found;
}

void add_options(const CLI::App& app, std::vector<std::string>& offers) {
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // of earlier releases
    for (const auto& name : option->get_lnames()) offers.push_back("--" + name);
  }
}

/// An option that waits for its value.
bool expects_value(const CLI::App& app, const CLI::App* sub, const std::string& word) {
  for (const auto* one : {sub, &app}) {
    const auto* option = one && word.starts_with("--") ? one->get_option_no_throw(word) : nullptr;
    if (option) return option->get_items_expected_max() > 0;
  }
  return false;
}

bool is_below(const CLI::App& sub, const char* name) {
  return sub.get_parent() != nullptr && sub.get_parent()->get_name() == name;
}

bool is_of_trust(const CLI::App& sub) {
  return is_below(sub, "trust") || is_below(sub, "broker");
}

/// After so many words behind a command of `rubicon trust`.
Wanted wanted_of_trust(const CLI::App& sub, std::size_t words) {
  const auto& command = sub.get_name();
  if (command == "revoke" || command == "renew" || command == "change")
    return words > 0 ? Wanted::kNoFile : Wanted::kMember;
  if (command == "may") return words == 0 ? Wanted::kMember : words == 2 ? Wanted::kTuple : Wanted::kNoFile;
  return command == "join" || command == "show" || command == "init" || command == "audit" || command == "mosquitto"
             ? Wanted::kNothing
             : Wanted::kNoFile;
}

/// The words after the command that are neither options nor their values.
std::vector<std::string> words_behind(const CLI::App& app, const CLI::App& sub,
                                      const std::vector<std::string>& before) {
  std::vector<std::string> words;
  bool behind = false, value = false;
  for (const auto& word : before) {
    if (behind && !value && !word.starts_with("-")) words.push_back(word);
    value = expects_value(app, &sub, word);
    behind = behind || word == sub.get_name();
  }
  return words;
}

}  // namespace

Question wanted_at(const CLI::App& app, const std::vector<std::string>& before) {
  const auto* sub = subcommand_in(app, before);
  if (!sub) return {};
  if (!before.empty() && expects_value(app, sub, before.back())) return {};
  const auto words = words_behind(app, *sub, before);
  const auto& name = sub->get_name();
  if (is_of_trust(*sub)) return {wanted_of_trust(*sub, words.size()), {}};
  const auto is = [&name](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is({"set", "append"}) && !words.empty()) {
    return words.size() == 1 && name == "set" ? Question{Wanted::kValue, words[0]} : Question{};
  }
  if (is({"describe", "rename"})) return {words.empty() ? Wanted::kDevice : Wanted::kNothing, {}};
  if (name == "send") return {words.empty() ? Wanted::kComponent : Wanted::kNothing, {}};
  if (name == "inbox") return {words.empty() ? Wanted::kNothing : Wanted::kWaiting, {}};
  return {is({"ls", "get", "set", "append", "delete", "watch", "top"}) ? Wanted::kTuple : Wanted::kNothing, {}};
}

std::vector<std::string> value_words(const std::string& description) {
  const auto about = model::point_description_from_json(description);
  if (!about) return {};
  std::vector<std::string> all;
  for (const auto& word : about->words) all.push_back(word.text);
  if (all.empty() && about->data_type == "boolean") all = {"off", "on"};
  return all;
}

std::vector<std::string> fixed_offers(const CLI::App& app, const std::vector<std::string>& before,
                                      const std::string& typed) {
  std::vector<std::string> offers;
  const auto* sub = subcommand_in(app, before);
  if (!before.empty() && expects_value(app, sub, before.back())) return offers;
  if (typed.starts_with("-")) {
    if (sub) add_options(*sub, offers);
    add_options(app, offers);
  } else if (!sub || !subcommands_of(*sub).empty()) {
    for (const auto* one : subcommands_of(sub ? *sub : app)) {
      if (!one->get_group().empty()) offers.push_back(one->get_name());
    }
  } else if (is_of_trust(*sub)) {
    if (sub->get_name() == "may" && words_behind(app, *sub, before).size() == 1)
      offers = {"read", "demand", "set", "approve", "send"};
  } else if (before.back() == "settings") {
    offers = {"show", "try", "reload"};
  } else if (before.size() > 1 && before[before.size() - 2] == "recorder") {
    offers = {"start", "stop", "mark"};
  } else if (before.size() > 1 && before[before.size() - 2] == "replay") {
    offers = {"play", "pause", "speed", "seek"};
  } else if (before.back() == "inbox") {
    offers = {"list", "approve", "ignore"};
  } else if (before.back() == "completion") {
    offers = {"bash", "zsh"};
  }
  return offers;
}

std::vector<Pattern> questions_for(const std::string& typed, const std::string& prefix) {
  std::vector<Pattern> questions;
  const auto ask = [&](const std::string& text) {
    if (auto pattern = Pattern::parse(text)) questions.push_back(std::move(*pattern));
  };
  const auto last_dot = typed.rfind('.');
  if (last_dot == typed.npos) {
    const auto colon = typed.find(':');
    const auto owner = colon == typed.npos ? std::string() : typed.substr(0, colon + 1);
    if (prefix.starts_with(typed.substr(owner.size()))) ask(owner + model::IslandKey{prefix}.networks());
    return questions;
  }
  const auto known = typed.substr(0, last_dot);
  if (std::count(known.begin(), known.end(), '.') >= 2) {
    ask(known + ".**");
  } else {
    ask(known + ".*.status");
    ask(known + ".*");
  }
  return questions;
}

std::string next_step(const std::string& name, const std::string& typed) {
  if (!name.starts_with(typed)) return {};
  const auto dot = name.find('.', typed.size());
  return dot == name.npos ? name : name.substr(0, dot + 1);
}

}  // namespace rubicon::cli
