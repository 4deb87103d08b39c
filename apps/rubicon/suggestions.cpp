#include "apps/rubicon/suggestions.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "apps/rubicon/session.h"
#include "base/nearest.h"
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

void each_point(const client::Device& device, const std::function<void(Kind, const std::string&)>& visit) {
  for (const auto& id : device.sensors) visit(Kind::kSensor, id);
  for (const auto& id : device.actuators) visit(Kind::kActuator, id);
  for (const auto& id : device.properties) visit(Kind::kProperty, id);
}

/// Spelling with as many parts as were typed -> what is offered for it.
std::multimap<std::string, std::string> spellings(const std::vector<client::Device>& devices, std::size_t parts) {
  std::multimap<std::string, std::string> all;
  for (const auto& device : devices) {
    each_point(device, [&](Kind kind, const std::string& id) {
      const auto short_name = device.id + "." + id;
      if (parts == 1) all.emplace(id, short_name);
      if (parts == 2) all.emplace(short_name, short_name);
      if (parts == 3) all.emplace(device.network + "." + short_name, device.network + "." + short_name);
      if (parts == kPointParts) {
        const auto key = model::DeviceKey{device.key()}.point(kind, id).text;
        all.emplace(key, key);
      }
    });
  }
  return all;
}

std::string question(const std::vector<std::string>& offers) {
  std::string text;
  for (std::size_t i = 0; i < offers.size() && i < kOffered; ++i)
    text += fmt::format("{}'{}'",
                        i == 0                                       ? "did you mean "
                        : i + 1 == std::min(offers.size(), kOffered) ? " or "
                                                                     : ", ",
                        offers[i]);
  return text.empty() ? text : text + "?";
}

}  // namespace

std::string suggest_point(const std::vector<client::Device>& devices, std::string_view typed) {
  const auto all = spellings(devices, model::key_parts(typed).size());
  std::vector<std::string> words, offers;
  for (const auto& [word, offer] : all) words.push_back(word);
  for (const auto& word : base::nearest(typed, words)) {
    const auto [first, last] = all.equal_range(word);
    for (auto it = first; it != last; ++it) {
      if (std::find(offers.begin(), offers.end(), it->second) == offers.end()) offers.push_back(it->second);
    }
  }
  return question(offers);
}

std::string suggest_tuple(Session& session, std::string_view typed, std::string_view last) {
  auto key = typed;
  const auto owner = take_owner(key);
  const auto parts = model::key_parts(key).size();
  const auto patience = session.settings().patience;
  if (parts <= 3 || parts == kPointParts) {
    const auto found = suggest_point(session.client().devices({}, patience), key);
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

std::string suggest_device(const std::vector<client::Device>& devices, std::string_view typed) {
  take_owner(typed);
  std::vector<std::string> words;
  for (const auto& device : devices) {
    words.push_back(device.id);
    words.push_back(device.name);
    words.push_back(device.network + "." + device.id);
    words.push_back(device.key());
  }
  return base::did_you_mean(typed, words);
}

std::string suggest_type(const std::vector<client::Device>& devices, std::string_view typed) {
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
  return base::did_you_mean(typed, words);
}

}  // namespace rubicon::cli
