#include "apps/rubicon/island_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/rubicon/session.h"
#include "base/nearest.h"
#include "base/text.h"

namespace rubicon::cli {

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

std::vector<OwnerId> islands_called(Session& session, std::string_view name) {
  session.discover();
  std::vector<OwnerId> found;
  for (const auto& one : session.client().islands()) {
    if (one.summary.name == name) found.push_back(one.id);
  }
  return found;
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
  const auto found = islands_called(session, word);
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

std::string with_island_id(Session& session, std::string_view text) {
  const auto colon = text.find(':');
  const auto name = text.substr(0, colon);
  if (colon == text.npos || name == "*" || is_number(name)) return std::string(text);
  const auto found = islands_called(session, name);
  return found.size() == 1 ? fmt::format("{}{}", number(found.front()), text.substr(colon)) : std::string(text);
}

std::vector<std::string> with_island_ids(Session& session, const std::vector<std::string>& texts) {
  std::vector<std::string> all;
  for (const auto& text : texts) all.push_back(with_island_id(session, text));
  return all;
}

}  // namespace rubicon::cli
