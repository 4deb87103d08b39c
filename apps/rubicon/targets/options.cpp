#include "apps/rubicon/targets/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ctime>

#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/session.h"
#include "apps/rubicon/targets/suggestions.h"
#include "base/compare_text.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::cli {

std::vector<client::IslandName> known_islands(Session& session) {
  session.discover();
  return client::islands_in(session.client().tuples());
}

namespace {

bool is_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == word.npos;
}

std::optional<OwnerId> island_id(std::string_view word) {
  const auto id = base::parse_number<std::uint32_t>(word);
  return id && *id >= 1 && *id <= model::kMaxIslandId ? std::optional(OwnerId(*id)) : std::nullopt;
}

/// The error in the text of an island; empty if it may be one.
std::string check_island(const std::string& word) {
  if (word.empty() || (is_number(word) && !island_id(word)))
    return fmt::format("is '{}', expected the id (1 to {}) or the name of an island", word, model::kMaxIslandId);
  return {};
}

int no_island(Session& session, std::string_view word) {
  std::vector<std::string> names;
  for (const auto& one : session.client().islands()) names.push_back(one.summary.name);
  auto hint = base::did_you_mean(word, names);
  if (hint.empty()) hint = "`rubicon islands` lists them";
  return session.not_found(fmt::format("no island {}", model::quoted(word)), hint);
}

/// A word is an id or a name: kGood and the island in `id`, or the exit code.
int find_island(Session& session, const std::string& word, std::optional<OwnerId>& id) {
  if (const auto error = check_island(word); !error.empty()) {
    print_error("the island " + error);
    return kUsage;
  }
  if (id = island_id(word); id) return kGood;
  const auto found = client::take_islands(known_islands(session), word + ":").islands;
  if (found.empty()) return no_island(session, word);
  id = found.front();
  if (found.size() == 1) return kGood;
  std::vector<std::uint32_t> ids;
  for (const auto one : found) ids.push_back(number(one));
  print_error(
      fmt::format("{} is the name of several islands; use an id: {}", model::quoted(word), fmt::join(ids, " or ")));
  return kUsage;
}

}  // namespace

CLI::Option* IslandOption::add_to(CLI::App* app, const std::string& about) {
  return app->add_option("--island", word_, about)
      ->type_name("ISLAND")
      ->check(CLI::Validator([](std::string& word) { return check_island(word); }, ""));
}

int IslandOption::find(Session& session) {
  return word_.empty() ? static_cast<int>(kGood) : find_island(session, word_, id_);
}

int IslandOption::find(Session& session, std::string& network) {
  if (const int code = find(session); code != kGood) return code;
  const auto colon = network.find(':');
  if (colon == std::string::npos) return kGood;
  if (network.starts_with("*:")) return network.erase(0, 2), kGood;
  std::optional<OwnerId> named;
  if (const int code = find_island(session, network.substr(0, colon), named); code != kGood) return code;
  if (id_ && *id_ != *named) {
    print_error(fmt::format("{} is a network of island {}, but --island is {}", model::quoted(network), number(*named),
                            model::quoted(word_)));
    return kUsage;
  }
  id_ = named;
  network.erase(0, colon + 1);
  return kGood;
}

int IslandOption::put_before(Session& session, std::vector<std::string>& texts) {
  if (const int code = find(session); code != kGood || !id_) return code;
  const auto islands = known_islands(session);
  for (auto& text : texts) {
    const auto of = client::take_islands(islands, text);
    if (!of.islands.empty() && of.islands != std::vector{*id_}) {
      print_error(fmt::format("{} is of another island than --island {}", model::quoted(text), model::quoted(word_)));
      return kUsage;
    }
    text = fmt::format("{}:{}", number(*id_), of.rest);
  }
  return kGood;
}

int IslandOption::put_before(Session& session, std::string& text) {
  std::vector<std::string> texts{std::move(text)};
  const int code = put_before(session, texts);
  text = std::move(texts.front());
  return code;
}

int with_island(Session& session, IslandOption& island, const std::function<int()>& run) {
  const int code = island.find(session);
  return code == kGood ? run() : code;
}

int with_network(Session& session, IslandOption& island, std::string& network, const std::function<int()>& run) {
  const int code = island.find(session, network);
  return code == kGood ? run() : code;
}

std::vector<OwnerId> components_called(Session& session, std::string_view word) {
  const auto id = base::parse_number<std::uint32_t>(word);
  session.discover();
  std::vector<OwnerId> found;
  for (const auto& one : session.client().components()) {
    if (id ? one.id == OwnerId(*id) : one.summary.name == word) found.push_back(one.id);
  }
  return found;
}

std::vector<client::IslandName> islands_for(Session& session, std::string_view text) {
  const auto name = text.substr(0, text.find(':'));
  if (name.size() == text.size() || name == "*" || is_number(name)) return {};
  return known_islands(session);
}

std::string with_island_id(Session& session, std::string_view text) {
  return client::with_island_id(islands_for(session, text), text);
}

std::vector<std::string> with_island_ids(Session& session, const std::vector<std::string>& texts) {
  std::vector<std::string> all;
  for (const auto& text : texts) all.push_back(with_island_id(session, text));
  return all;
}

ChosenIsland choose_island(Session& session, const IslandOption& option, const std::string& key,
                           const std::string& what) {
  std::vector<OwnerId> islands;
  std::vector<std::string> names;
  for (const auto& tuple : session.read({option.owner(), key})) {
    islands.push_back(tuple.owner);
    names.push_back(session.component_text(tuple.owner));
  }
  if (islands.size() == 1) return {islands.front(), kGood};
  if (islands.empty()) return {{}, session.not_found("no " + what)};
  print_error(fmt::format("{} is of the islands {}; choose one with --island", what, fmt::join(names, ", ")));
  return {{}, kUsage};
}

int command_island(Session& session, OwnerId island, const std::string& key, const std::string& text,
                   const std::string& done) {
  const auto outcome = session.command(island, key, text);
  if (session.json()) {
    session.out().line(model::dump({{"island", number(island)},
                                    {"key", key},
                                    {"value", text},
                                    {"state", outcome.state},
                                    {"reason", outcome.reason}}));
  } else if (outcome.good()) {
    if (!done.empty()) session.out().line(done);
  } else {
    print_error(fmt::format("{}: {}", outcome.state, printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

void DeviceOptions::add_to(CLI::App& app) {
  island_.add_to(&app, "of this island only: id or name");
  app.add_option("--network", network_, "of this network; * and ? as in a shell; ISLAND: in front");
  app.add_option("--type", type_, "of this type, or with a sensor, actuator or property of it");
  app.add_option("--name", name_, "with this name, key part or address");
  app.add_option("--area", area_, "in this room or place");
}

int DeviceOptions::run(Session& session, const std::function<int(const client::DeviceQuery&)>& command) {
  return with_network(session, island_, network_, [&] {
    return command({island_.owner(), network_, type_, name_, area_});
  });
}

client::KnownNames known_names(Session& session) {
  auto islands = known_islands(session);
  client::KnownNames names{session.client().devices({}, session.settings().patience), std::move(islands), {}};
  client::add_names(session.read(client::name_patterns().back()), names);
  return names;
}

int ambiguous(std::string_view word, const std::vector<client::Device>& candidates) {
  std::string names;
  for (const auto& one : candidates) names += "\n  " + name_of(one.island, one.key());
  print_error(fmt::format("{} is ambiguous; name one of these devices:{}", model::quoted(word), names));
  return kUsage;
}

int one_device(Session& session, std::string_view word, client::Device& device) {
  return one_device(session, known_names(session), word, device);
}

int one_device(Session& session, const client::KnownNames& names, std::string_view word, client::Device& device) {
  auto found = client::devices_called(names, word);
  if (found.empty())
    return session.not_found(fmt::format("no device {}", model::quoted(word)), suggest_device(names, word));
  if (found.size() > 1) return ambiguous(word, found);
  device = std::move(found[0]);
  return kGood;
}

std::string check_time(const std::string& text) {
  if (time_in(text, WallTime(std::chrono::hours(24 * 20'000)))) return {};
  return text + ": expected now, a span before it (2h), seconds since 1970, or 2026-01-31T12:00:00Z";
}

CLI::Option* add_time_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about) {
  return app->add_option(name, text, about)->type_name("TIME")->check(check_time);
}

std::optional<WallTime> time_in(const std::string& text, WallTime now) {
  if (text == "now") return now;
  if (const auto span = base::parse_duration(text))
    return now - std::chrono::duration_cast<std::chrono::microseconds>(*span);
  if (const auto seconds = base::parse_number<double>(text)) {
    const auto time = model::time_from_seconds(*seconds);
    return time == WallTime() ? std::nullopt : std::optional(time);
  }
  std::tm calendar{};
  const auto* end = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &calendar);
  if (end == nullptr || *end != '\0') return std::nullopt;
  return WallTime(std::chrono::seconds(::timegm(&calendar)));
}

}  // namespace rubicon::cli
