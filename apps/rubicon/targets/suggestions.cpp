#include "apps/rubicon/targets/suggestions.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/rubicon/session.h"
#include "apps/rubicon/targets/options.h"
#include "base/compare_text.h"
#include "client/json_forms.h"
#include "model/point_keys.h"
#include "model/type_catalogue.h"

namespace rubicon::cli {

namespace {

/// Names that are offered.
constexpr std::size_t kOffered = 3;
/// Parts of the key of a point.
constexpr std::size_t kPointParts = 5;

/// `6541:` in front of the rest, which stays in `text`.
std::string take_owner(std::string_view& text) {
  const auto colon = text.find(':');
  if (colon == text.npos) return {};
  const std::string owner(text.substr(0, colon + 1));
  text.remove_prefix(owner.size());
  return owner;
}

/// Spelling with as many parts as were typed -> what is offered for it.
std::multimap<std::string, std::string> spellings(const std::vector<std::string>& keys, std::size_t parts) {
  std::multimap<std::string, std::string> all;
  for (const auto& key : keys) {
    const auto part = model::key_parts(key);
    if (part.size() != kPointParts) continue;
    const auto id = std::string(part[4]), short_name = fmt::format("{}.{}", part[2], id);
    if (parts == 1) all.emplace(id, short_name);
    if (parts == 2) all.emplace(short_name, short_name);
    if (parts == 3) all.emplace(fmt::format("{}.{}", part[1], short_name), fmt::format("{}.{}", part[1], short_name));
    if (parts == kPointParts) all.emplace(key, key);
  }
  return all;
}

std::string listed(const std::vector<std::string>& offers) {
  std::string text;
  const auto shown = std::min(offers.size(), kOffered);
  for (std::size_t i = 0; i < shown; ++i)
    text += fmt::format("{}'{}'", i == 0 ? "" : i + 1 == shown ? " or " : ", ", offers[i]);
  return text;
}

/// The keys of the points that have the tuple `last`.
std::vector<std::string> keys_of_points(Session& session, std::optional<OwnerId> owner, const std::string& points,
                                        std::string_view last) {
  std::vector<std::string> keys;
  for (const auto& tuple : session.read({owner, fmt::format("{}.{}", points, last)}))
    keys.emplace_back(model::parent_key(tuple.key));
  return keys;
}

}  // namespace

std::string suggest_point(const std::vector<std::string>& keys, std::string_view typed) {
  const auto all = spellings(keys, model::key_parts(typed).size());
  std::vector<std::string> words, offers;
  for (const auto& [word, offer] : all) words.push_back(word);
  for (const auto& word : base::nearest(typed, words)) {
    const auto [first, last] = all.equal_range(word);
    for (auto it = first; it != last; ++it) {
      const bool is_offered = std::find(offers.begin(), offers.end(), it->second) != offers.end();
      if (!is_offered && it->second != typed) offers.push_back(it->second);
    }
  }
  return offers.empty() ? std::string() : fmt::format("did you mean {}?", listed(offers));
}

std::string suggest_settable(Session& session, OwnerId island, std::string_view point) {
  const auto network = model::network_of(point);
  const auto part = model::key_parts(point);
  if (!network || part.size() != kPointParts) return {};
  auto keys = keys_of_points(session, island, network->device(part[2]).point("*", "*").text, "command");
  std::sort(keys.begin(), keys.end(), base::natural_less);
  std::vector<std::string> names;
  for (const auto& key : keys) names.push_back(fmt::format("{}.{}", part[2], model::last_part(key)));
  if (names.empty()) return fmt::format("nothing of {} can be set", part[2]);
  const auto more = names.size() > kOffered ? fmt::format("; `rubicon describe {}` lists all", part[2]) : "";
  return fmt::format("of {} can be set: {}{}", part[2], listed(names), more);
}

namespace {

/// Among the names that people give.
std::string suggest_name(Session& session, std::string_view typed, std::string_view last) {
  const auto names = known_names(session);
  const auto among = last == "command" ? client::Among::kSettable : client::Among::kAll;
  if (const auto near = client::near_points(names, typed, among); !near.empty())
    return fmt::format("did you mean {}?", listed(near));
  const auto devices = client::devices_called(names, typed);
  if (devices.empty()) return {};
  for (const auto& place : client::places_of(devices.front())) {
    if (among == client::Among::kAll || place.kind != Kind::kSensor)
      return fmt::format("name a point of it, such as '{}.{}'", printable(typed), place.id);
  }
  return {};
}

}  // namespace

std::string suggest_tuple(Session& session, std::string_view typed, std::string_view last) {
  if (auto name = suggest_name(session, typed, last); !name.empty()) return name;
  auto key = typed;
  const auto owner = take_owner(key);
  const auto parts = model::key_parts(key).size();
  if (parts <= 3 || parts == kPointParts) {
    const auto points = Pattern::parse(owner + model::any_point().text);
    const auto found =
        points ? suggest_point(keys_of_points(session, points->owner, points->key, last), key) : std::string();
    if (!found.empty()) return found;
  }
  std::string pattern = owner + "*";
  for (std::size_t i = 1; i < parts; ++i) pattern += ".*";
  const auto parsed = Pattern::parse(pattern);
  if (!parsed) return {};
  std::vector<std::string> keys;
  for (const auto& tuple : session.read(*parsed)) {
    const bool meant = parts != kPointParts + 1 || last.empty() || tuple.key.ends_with(last);
    if (meant) keys.push_back(tuple.key);
  }
  return base::did_you_mean(key, keys);
}

std::string suggest_device(const client::KnownNames& names, std::string_view typed) {
  const auto of = client::take_islands(names.islands, typed);
  std::vector<std::string> words;
  for (const auto& device : names.devices) {
    if (!of.fit(device.island)) continue;
    for (const auto& word : {device.id, device.name, device.network + "." + device.id, device.key(), device.area})
      words.push_back(word);
  }
  return base::did_you_mean(of.rest, words);
}

std::vector<std::string> type_words(const std::vector<client::Device>& devices) {
  const TypeCatalogue catalogue;
  std::vector<std::string> words;
  for (const auto* type : catalogue.all()) words.emplace_back(type->name);
  for (const auto& device : devices) {
    words.push_back(device.type);
    words.push_back(device.model);
    for (const auto* ids : {&device.sensors, &device.actuators, &device.properties}) {
      for (const auto& id : *ids) words.push_back(id.substr(0, id.find('-')));  // also types that devices name
    }
  }
  std::erase(words, std::string());
  return words;
}

std::string suggest_type(const std::vector<client::Device>& devices, std::string_view typed) {
  return base::did_you_mean(typed, type_words(devices));
}

}  // namespace rubicon::cli
