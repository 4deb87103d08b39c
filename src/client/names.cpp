#include "client/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/compare_text.h"
#include "base/letter_case.h"
#include "base/text.h"
#include "client/json_forms.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "model/type_names.h"

namespace rubicon::client {

namespace {

/// How well a word fits a name; the lowest number is best.
constexpr int kNotAtAll = 99;
/// Suggestions.
constexpr std::size_t kMaxNear = 3;

/// A word that is compared exactly, and without case.
class Word {
 public:
  explicit Word(std::string_view text) : text_(text), small_(base::to_lower(text)) {}

  const std::string& text() const { return text_; }
  bool is(std::string_view name) const { return name == text_; }
  bool is_like(std::string_view name) const { return name.size() == text_.size() && base::to_lower(name) == small_; }

 private:
  std::string text_, small_;
};

std::string with_network(const Device& device) {
  return device.network + "." + device.id;
}

/// How well a word fits a device: by its key, by what people call it, by where it is.
int rank_of_device(const Word& word, const Device& device) {
  const auto key = device.key();
  const std::string_view of_network = std::string_view(key).substr(device.prefix.size() + 1);
  const std::array<std::string_view, 3> keys{device.id, of_network, key};
  const std::array<std::string_view, 2> names{device.name, device.address};
  const auto any = [&word](const auto& texts, bool (Word::*fits)(std::string_view) const) {
    return std::any_of(texts.begin(), texts.end(),
                       [&](std::string_view text) { return !text.empty() && (word.*fits)(text); });
  };
  if (any(keys, &Word::is)) return 0;
  if (any(names, &Word::is)) return 1;
  if (any(keys, &Word::is_like) || any(names, &Word::is_like)) return 2;
  if (device.area.empty()) return kNotAtAll;
  return word.is(device.area) ? 3 : word.is_like(device.area) ? 4 : kNotAtAll;
}

std::vector<Place> places_among(const Device& device, Among among) {
  auto all = places_of(device);
  if (among == Among::kSettable) std::erase_if(all, [](const Place& place) { return place.kind == Kind::kSensor; });
  return all;
}

/// How well a word fits a point: its id, the name it was given, its type, the name in its id. The id of a property is
/// none of its own.
int rank_of_point(const Word& word, const Place& place, std::string_view name) {
  const std::string_view id = place.id;
  if (word.is(id)) return 0;
  if (!name.empty() && word.is(name)) return 1;
  if (word.is_like(id) || (!name.empty() && word.is_like(name))) return 2;
  const auto dash = id.find('-');
  if (dash == id.npos || place.kind == Kind::kProperty) return kNotAtAll;
  const auto type = id.substr(0, dash), instance = id.substr(dash + 1);
  if (word.is_like(type)) return 3;
  return word.is_like(instance) && !base::parse_number<unsigned>(instance) ? 4 : kNotAtAll;
}

bool is_glob(std::string_view text) {
  return text.find_first_of("*?") != text.npos;
}

Pattern point_at(const Device& device, std::string_view kind, std::string_view id) {
  return {device.island, model::DeviceKey{device.key()}.point(kind, id).text};
}

std::string key_of(const Device& device, const Place& place) {
  return model::DeviceKey{device.key()}.point(place.kind, place.id).text;
}

/// The points of a device that a POINT may mean.
std::vector<Pattern> points_in(const KnownNames& names, const Device& device, const Word& point, Among among) {
  const auto places = places_among(device, among);
  if (is_glob(point.text())) {
    const bool fits = std::any_of(places.begin(), places.end(),
                                  [&](const Place& place) { return base::glob_matches(point.text(), place.id); });
    return fits ? std::vector{point_at(device, "*", point.text())} : std::vector<Pattern>();
  }
  int best = kNotAtAll - 1;
  std::vector<Pattern> found;
  for (const auto& place : places) {
    const auto key = key_of(device, place);
    const int rank = rank_of_point(point, place, name_of_point(names, device.island, key));
    if (rank > best) continue;
    if (rank < best) found.clear();
    best = rank;
    found.push_back({device.island, key});
  }
  return found;
}

/// `ISLAND:DEVICE.POINT`, in its three parts; empty ones if it is not of that form.
struct Parts {
  OfIslands of;
  std::string device, point;
};

/// Split at the last dot before `end`; names of points may have dots.
Parts parts_of(const KnownNames& names, std::string_view text, std::size_t end = std::string_view::npos) {
  Parts parts{take_islands(names.islands, text), {}, {}};
  const auto rest = parts.of.rest;
  const auto dot = rest.rfind('.', end);
  if (dot == rest.npos || dot == 0 || dot + 1 == rest.size()) return parts;
  parts.device = rest.substr(0, dot);
  constexpr std::string_view kDevice = "device.";
  const auto key = model::without_alias(std::string(kDevice) + std::string(rest.substr(dot + 1)));
  parts.point = model::current_id(key.substr(kDevice.size()));
  return parts;
}

}  // namespace

bool OfIslands::fit(OwnerId island) const {
  return islands.empty() || std::find(islands.begin(), islands.end(), island) != islands.end();
}

OfIslands take_islands(const std::vector<IslandName>& islands, std::string_view text) {
  const OfIslands none{{}, {}, text};
  const auto colon = text.find(':');
  if (colon == text.npos || colon == 0) return none;
  OfIslands found{{}, text.substr(0, colon + 1), text.substr(colon + 1)};
  const Word word(text.substr(0, colon));
  if (word.is("*")) return found;
  if (const auto id = base::parse_number<std::uint32_t>(word.text())) {
    found.islands.push_back(OwnerId(*id));
    return found;
  }
  for (const auto fits : {&Word::is, &Word::is_like}) {
    for (const auto& one : islands) {
      if ((word.*fits)(one.name)) found.islands.push_back(one.id);
    }
    if (!found.islands.empty()) return found;
  }
  return none;
}

std::vector<Device> devices_called(const KnownNames& names, std::string_view text) {
  const auto of = take_islands(names.islands, text);
  const Word word(of.rest);
  int best = kNotAtAll - 1;
  std::vector<Device> found;
  for (const auto& device : names.devices) {
    const int rank = of.fit(device.island) ? rank_of_device(word, device) : kNotAtAll;
    if (rank > best) continue;
    if (rank < best) found.clear();
    best = rank;
    found.push_back(device);
  }
  return found;
}

namespace {

std::vector<Pattern> points_at(const KnownNames& names, const Parts& parts, Among among) {
  const Word device_word(parts.device), point(parts.point);
  int best = kNotAtAll - 1;
  std::vector<Pattern> found;
  for (const auto& device : names.devices) {
    const int rank = parts.of.fit(device.island) ? rank_of_device(device_word, device) : kNotAtAll;
    if (rank > best) continue;
    auto points = points_in(names, device, point, among);
    // What is to be set must not be looked for in a device that is called so by chance.
    if (points.empty() && among == Among::kAll) continue;
    if (rank < best) found.clear();
    best = rank;
    std::move(points.begin(), points.end(), std::back_inserter(found));
  }
  return found;
}

/// The points whose own name is the whole text.
std::vector<Pattern> points_named(const KnownNames& names, std::string_view text, Among among) {
  const auto of = take_islands(names.islands, text);
  const Word word(of.rest);
  for (const auto fits : {&Word::is, &Word::is_like}) {
    std::vector<Pattern> found;
    for (const auto& [place, name] : names.points) {
      const bool counts = among == Among::kAll || place.second.find(".sensor.") == std::string::npos;
      if (counts && of.fit(place.first) && (word.*fits)(name)) found.push_back({place.first, place.second});
    }
    if (!found.empty()) return found;
  }
  return {};
}

}  // namespace

std::vector<Pattern> points_called(const KnownNames& names, std::string_view text, Among among) {
  const auto rest = take_islands(names.islands, text).rest;
  for (auto dot = rest.rfind('.'); dot != rest.npos && dot > 0; dot = rest.rfind('.', dot - 1)) {
    const auto parts = parts_of(names, text, dot);
    if (parts.device.empty()) continue;
    if (auto found = points_at(names, parts, among); !found.empty()) return found;
  }
  return points_named(names, text, among);
}

void add_point_names(OwnerId island, std::string_view key, std::string_view overview, KnownNames& names) {
  const auto prefix = key.substr(0, key.find('.'));
  const auto arranged = model::object_of(overview);
  const auto given = arranged.find("names");
  if (given == arranged.end() || !given->is_object()) return;
  for (const auto& [point, name] : given->items()) {
    if (name.is_string()) names.points[{island, fmt::format("{}.{}", prefix, point)}] = name.get<std::string>();
  }
}

std::string name_of_point(const KnownNames& names, OwnerId island, const std::string& key) {
  const auto found = names.points.find({island, key});
  return found == names.points.end() ? std::string() : found->second;
}

std::string name_of(const KnownNames& names, std::string_view key) {
  const auto of = take_islands(names.islands, key);
  const auto parts = model::key_parts(of.rest);
  constexpr std::size_t kDeviceParts = 3, kPointParts = 5;
  if (of.islands.size() != 1 || parts.size() < kDeviceParts) return {};
  const auto device = std::find_if(names.devices.begin(), names.devices.end(), [&](const Device& one) {
    return one.island == of.islands.front() && one.prefix == parts[0] && one.network == parts[1] && one.id == parts[2];
  });
  if (device == names.devices.end()) return {};
  if (parts.size() < kPointParts) return device->name;
  const auto point =
      name_of_point(names, device->island, model::DeviceKey{device->key()}.point(parts[3], parts[4]).text);
  return point.empty() ? device->name : fmt::format("{}, {}", device->name, point);
}

bool is_like_name(std::string_view text) {
  const bool has_controls = std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; });
  return !text.empty() && !has_controls && text.front() != '.' && text.back() != '.' && text.find("..") == text.npos;
}

namespace {

/// Of devices that have the name: what stands behind the dot may be wrong.
std::vector<std::string> near_ids(const KnownNames& names, const std::vector<Device>& devices, const Parts& parts,
                                  Among among) {
  std::vector<std::string> ids;
  for (const auto& device : devices) {
    for (const auto& place : places_among(device, among)) {
      ids.push_back(place.id);
      if (auto name = name_of_point(names, device.island, key_of(device, place)); !name.empty())
        ids.push_back(std::move(name));
    }
  }
  std::vector<std::string> near;
  for (const auto& id : base::nearest(parts.point, ids, kMaxNear)) {
    near.push_back(fmt::format("{}{}.{}", parts.of.before, parts.device, id));
  }
  return near;
}

}  // namespace

std::vector<std::string> near_points(const KnownNames& names, std::string_view text, Among among) {
  const auto parts = parts_of(names, text);
  if (parts.device.empty()) return {};
  const auto called = devices_called(names, std::string(parts.of.before) + parts.device);
  auto near = near_ids(names, called, parts, among);
  if (called.empty()) {
    std::vector<std::string> words;
    const Word point(parts.point);
    for (const auto& device : names.devices) {
      if (!parts.of.fit(device.island) || points_in(names, device, point, among).empty()) continue;
      for (const auto& word : {device.id, with_network(device), device.name, device.area}) words.push_back(word);
    }
    for (const auto& word : base::nearest(parts.device, words, kMaxNear))
      near.push_back(fmt::format("{}{}.{}", parts.of.before, word, parts.point));
  }
  std::erase(near, text);
  return near;
}

}  // namespace rubicon::client
