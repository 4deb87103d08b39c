#include "apps/rubicon/commands/completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"
#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "client/json_forms.h"
#include "client/names.h"
#include "model/json_members.h"
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

/// Number of words after a command of `rubicon trust`.
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

Wanted wanted_of_option(const std::string& command, const std::string& option) {
  if (option == "--island") return Wanted::kIsland;
  return option == "--type" && (command == "devices" || command == "tree") ? Wanted::kType : Wanted::kNothing;
}

}  // namespace

Question wanted_at(const CLI::App& app, const std::vector<std::string>& before) {
  const auto* sub = subcommand_in(app, before);
  if (!sub) return {};
  const auto& name = sub->get_name();
  if (!before.empty() && expects_value(app, sub, before.back())) return {wanted_of_option(name, before.back()), {}};
  const auto words = words_behind(app, *sub, before);
  if (is_of_trust(*sub)) return {wanted_of_trust(*sub, words.size()), {}};
  const auto is = [&name](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is({"set", "append"}) && !words.empty()) {
    return words.size() == 1 && name == "set" ? Question{Wanted::kValue, words[0]} : Question{};
  }
  if (is({"describe", "rename"})) return {words.empty() ? Wanted::kDevice : Wanted::kNothing, {}};
  if (name == "send") return {words.empty() ? Wanted::kComponent : Wanted::kNothing, {}};
  if (name == "inbox") {
    const bool is_listed = !words.empty() && words.front() == "forget";
    return {words.empty() ? Wanted::kNothing : is_listed ? Wanted::kDevice : Wanted::kWaiting, {}};
  }
  if (name == "record") return {words.empty() ? Wanted::kNothing : Wanted::kTuple, {}};
  if (name == "history") return {words.empty() ? Wanted::kTuple : Wanted::kNothing, {}};
  if (name == "set") return {Wanted::kSettable, {}};
  return {is({"ls", "get", "append", "delete", "watch", "top"}) ? Wanted::kTuple : Wanted::kNothing, {}};
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
  } else if (sub && sub->get_name() == "history" && words_behind(app, *sub, before).empty()) {
    return offers;  // a tuple, or a file
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

std::string next_name(const std::string& name, const std::string& point, const std::string& typed) {
  const auto whole = name + '.' + point;
  if (name.empty() || !whole.starts_with(typed)) return {};
  return typed.size() > name.size() ? whole : name + '.';
}

ShellLine split_line(std::string_view line) {
  ShellLine split{{""}, false};
  char quote = 0;
  bool in_word = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote == 0 && (c == ' ' || c == '\t')) {
      if (std::exchange(in_word, false)) split.words.emplace_back();
      continue;
    }
    in_word = true;
    if (c == quote || (quote == 0 && (c == '\'' || c == '"'))) {
      quote = c == quote ? '\0' : c;
    } else if (c == '\\' && quote != '\'') {
      if (++i < line.size()) split.words.back() += line[i];
    } else {
      split.words.back() += c;
    }
  }
  split.is_quoted = quote != 0;
  return split;
}

std::string for_bash(std::string_view offer, std::string_view typed, bool is_quoted, bool cut) {
  if (is_quoted) return std::string(offer);
  const auto colon = typed.rfind(':');
  if (cut && colon != typed.npos) offer.remove_prefix(colon + 1);
  std::string out;
  for (const char c : offer) {
    if (std::string_view(" \t\"'\\$`&|;<>()*?[]{}~#!").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

namespace {

/// What the questions of a completion share.
struct Asker {
  Client& client;
  Duration patience;

  auto read(const Pattern& pattern) const { return client.read(pattern, patience); }
};

/// Short unless --patience says how long, because a user waits at the keyboard.
Duration patience_of(const Settings& settings) {
  constexpr Duration kPatience = std::chrono::milliseconds(700);
  return settings.patience == Settings{}.patience ? kPatience : settings.patience;
}

std::set<std::string> keys(const Asker& asker, const std::string& typed, const std::string& prefix) {
  std::set<std::string> found;
  for (const auto& question : questions_for(typed, prefix)) {
    for (const auto& tuple : asker.read(question)) {
      const auto name = question.owner ? name_of(tuple.owner, tuple.key) : tuple.key;
      if (auto next = next_step(name, typed); !next.empty()) found.insert(std::move(next));
    }
  }
  return found;
}

client::KnownNames names_of(const Asker& asker) {
  client::KnownNames names{{}, client::islands_in(asker.client.tuples()), {}};
  for (const auto& pattern : client::name_patterns()) client::add_names(asker.read(pattern), names);
  return names;
}

/// By key and by name, behind the island that was typed.
std::set<std::string> devices(const client::KnownNames& names, const std::string& typed) {
  const auto of = client::take_islands(names.islands, typed);
  std::set<std::string> found;
  for (const auto& device : names.devices) {
    if (!of.fit(device.island)) continue;
    for (const auto& word : {device.id, device.network + "." + device.id, device.name}) {
      if (!word.empty()) found.insert(std::string(of.before) + word);
    }
  }
  return found;
}

/// The same of points.
std::set<std::string> points(const client::KnownNames& names, const std::string& typed,
                             const std::function<bool(const std::string& key)>& counts) {
  const auto of = client::take_islands(names.islands, typed);
  const std::string front(of.before), rest(of.rest);
  std::set<std::string> found;
  for (const auto& device : names.devices) {
    if (!of.fit(device.island)) continue;
    for (const auto& place : client::places_of(device)) {
      const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id).text;
      if (!counts(key)) continue;
      found.insert(fmt::format("{}{}.{}", front, device.id, place.id));
      const auto given = client::name_of_point(names, device.island, key);
      if (!given.empty()) found.insert(front + given);
      for (const auto& point : {place.id, given}) {
        if (point.empty()) continue;
        if (const auto next = next_name(device.name, point, rest); !next.empty()) found.insert(front + next);
      }
    }
  }
  return found;
}

/// The keys of the points that have a command.
std::set<std::string> settable(const Asker& asker) {
  std::set<std::string> found;
  for (const auto& tuple : asker.read({std::nullopt, model::any_point().command()}))
    found.emplace(model::parent_key(tuple.key));
  return found;
}

/// A key, or its beginning, of what can be set.
bool may_lead_to_command(const std::string& key) {
  if (key.find(".sensor.") != key.npos) return false;
  const auto last = model::last_part(key);
  return last != "value" && last != "status" && last != "description";
}

std::set<std::string> types(const client::KnownNames& names) {
  const auto all = type_words(names.devices);
  return {all.begin(), all.end()};
}

/// The descriptions of the point that is to be set.
std::vector<Pattern> descriptions(const Asker& asker, const std::string& tuple) {
  const auto typed = parse_target(tuple);
  if (typed) {
    const auto longer = long_form(*typed, "description");
    const Pattern whole{typed->owner, model::PointKey{std::string(model::parent_key(typed->key))}.description()};
    const auto one = longer.value_or(whole);
    if (!asker.read(one).empty()) return {one};
  }
  std::vector<Pattern> found;
  for (const auto& point : client::points_called(names_of(asker), tuple, client::Among::kSettable))
    found.push_back({point.owner, model::PointKey{point.key}.description()});
  return found;
}

/// The words of the actuator that is to be set.
std::set<std::string> values(const Asker& asker, const std::string& tuple) {
  std::set<std::string> found;
  for (const auto& pattern : descriptions(asker, tuple)) {
    for (const auto& one : asker.read(pattern)) {
      const auto words = value_words(one.value);
      found.insert(words.begin(), words.end());
    }
  }
  return found;
}

std::set<std::string> live(const Settings& settings, const Question& question, const std::string& typed) {
  auto options = settings.options;
  options.name = "rubicon complete";
  auto client = Client::open(options);
  if (!client) return {};
  (*client)->discover();
  const Asker asker{**client, patience_of(settings)};
  std::set<std::string> found;
  switch (question.wanted) {
    case Wanted::kTuple:
      found = keys(asker, typed, settings.prefix);
      found.merge(points(names_of(asker), typed, [](const auto&) { return true; }));
      break;
    case Wanted::kSettable: {
      const auto commands = settable(asker);
      found = keys(asker, typed, settings.prefix);
      std::erase_if(found, [](const auto& key) { return !may_lead_to_command(key); });
      found.merge(points(names_of(asker), typed, [&](const auto& key) { return commands.contains(key); }));
      break;
    }
    case Wanted::kValue: return values(asker, question.tuple);
    case Wanted::kDevice: return devices(names_of(asker), typed);
    case Wanted::kType: return types(names_of(asker));
    case Wanted::kIsland:
      for (const auto& one : (*client)->islands()) found.insert(one.summary.name);
      break;
    case Wanted::kComponent:
      for (const auto& one : (*client)->components()) found.insert(std::to_string(number(one.id)));
      break;
    case Wanted::kWaiting:
      for (const auto& tuple : asker.read({std::nullopt, model::IslandKey{settings.prefix}.inbox("*.*")}))
        found.insert(model::text_of(model::object_of(tuple.value), "key"));
      break;
    case Wanted::kMember:
    case Wanted::kNoFile:
    case Wanted::kNothing: break;
  }
  return found;
}

std::set<std::string> realm_members() {
  std::set<std::string> found;
  const auto there = rubicon::trust::site::contents_of(trust::site::folder_to_show(""), trust::now());
  if (!there) return found;
  for (const auto& one : there->members) found.insert(one.name);
  return found;
}

std::set<std::string> found_for(const Settings& settings, const Question& question, const std::string& typed) {
  switch (question.wanted) {
    case Wanted::kNothing:
    case Wanted::kNoFile: return {};
    case Wanted::kMember: return realm_members();
    default: return live(settings, question, typed);
  }
}

bool is_no_file(Wanted wanted) {
  return wanted == Wanted::kMember || wanted == Wanted::kNoFile;
}

struct CompleteOptions {
  std::vector<std::string> words{};
  std::string line{};
  bool cut = false;
};

int complete(const CLI::App& app, const Settings& settings, const CompleteOptions& options) {
  Output out(1);
  const auto split = split_line(options.line);
  auto before = options.words;
  if (!options.line.empty()) before.assign(split.words.begin() + 1, split.words.end());
  const auto typed = before.empty() ? std::string() : before.back();
  if (!before.empty()) before.pop_back();
  auto offers = fixed_offers(app, before, typed);
  const auto question = wanted_at(app, before);
  const bool takes_no_file = is_no_file(question.wanted);
  if (offers.empty()) {
    for (const auto& one : found_for(settings, question, typed)) offers.push_back(one);
  }
  bool is_offered = false;
  for (const auto& one : offers) {
    if (one.empty() || !one.starts_with(typed)) continue;
    const auto shown = printable(one);
    out.line(options.line.empty() ? shown : for_bash(shown, typed, split.is_quoted, options.cut));
    is_offered = true;
  }
  if (takes_no_file && !is_offered) out.line(kNoFiles);
  return ended(out, kGood);
}

}  // namespace

void add_complete(Cli& cli) {
  const auto options = std::make_shared<CompleteOptions>();
  auto* app = cli.command(
      {"complete", "Offer what the last of these words may become, for shells", "  rubicon complete -- watch proxy.\n"},
      [options, &cli](const Settings& settings) { return complete(cli.app(), settings, *options); });
  app->add_option("WORD", options->words, "the words of a command line behind the name of the program");
  app->add_option("--line", options->line, "the command line up to the cursor, in place of words, for bash");
  app->add_flag("--cut", options->cut, "bash replaces what stands behind the last colon");
  app->group("");
}

}  // namespace rubicon::cli
