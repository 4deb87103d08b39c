#include "console/live_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/natural_order.h"
#include "model/unit_text.h"
#include "rubicon/key.hpp"

namespace rubicon::console {

namespace {

using nlohmann::json;

json parsed(std::string_view text) {
  auto tree = json::parse(text, nullptr, false);
  return tree.is_object() ? tree : json::object();
}

std::string part_of(std::string_view key, std::size_t index) {
  const auto parts = model::key_parts(key);
  return index < parts.size() ? std::string(parts[index]) : std::string();
}

std::string without_last_part(std::string_view key) {
  return std::string(key.substr(0, key.rfind('.')));
}

/// A member that is text, else nothing.
std::string text_in(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// A member that is a time in seconds since 1970, else zero.
WallTime time_in(const json& object, const char* name) {
  constexpr double kLatest = 1e11;
  const auto found = object.find(name);
  const auto seconds = found != object.end() && found->is_number() ? found->get<double>() : 0;
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * 1e6)));
}

}  // namespace

LiveSource::LiveSource(const TupleSpace& space, OwnerId island, std::string prefix)
    : space_(space), island_(island), prefix_(std::move(prefix)) {}

std::string LiveSource::value(const std::string& key) const {
  const auto tuple = space_.get(island_, key);
  return tuple ? std::string(tuple->value) : std::string();
}

std::vector<LiveNetwork> LiveSource::networks() const {
  std::vector<LiveNetwork> all;
  space_.list({island_, prefix_ + ".*.status"}, [&](const tuples::TupleView& tuple) {
    const auto status = parsed(tuple.value);
    all.push_back({part_of(tuple.key, 1), text_in(status, "line"), text_in(status, "reason")});
  });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return base::natural_less(a.id, b.id); });
  return all;
}

std::vector<std::string> LiveSource::devices() const {
  std::vector<std::string> keys;
  space_.list({island_, prefix_ + ".*.*.status"},
              [&](const tuples::TupleView& tuple) { keys.push_back(without_last_part(tuple.key)); });
  std::sort(keys.begin(), keys.end(), base::natural_less);
  return keys;
}

LiveDevice LiveSource::device(const std::string& key) const {
  const auto status = parsed(value(key + ".status"));
  return {key,
          part_of(key, 1),
          part_of(key, 2),
          text_in(parsed(value(key + ".description")), "name"),
          text_in(status, "status"),
          text_in(status, "reason")};
}

std::vector<std::string> LiveSource::points(const std::string& device) const {
  std::vector<std::string> keys;
  for (const auto* kind : {"sensor", "actuator"}) {
    const auto begin = static_cast<std::ptrdiff_t>(keys.size());
    space_.list({island_, fmt::format("{}.{}.*.value", device, kind)},
                [&](const tuples::TupleView& tuple) { keys.push_back(without_last_part(tuple.key)); });
    std::sort(keys.begin() + begin, keys.end(), base::natural_less);
  }
  return keys;
}

LivePoint LiveSource::point(const std::string& key) const {
  const auto status = parsed(value(key + ".status"));
  const auto command = status.contains("command") ? status["command"] : json::object();
  return {key,
          part_of(key, 4),
          value(key + ".value"),
          model::unit_text(text_in(parsed(value(key + ".description")), "unit")),
          text_in(status, "quality"),
          command.is_object() ? text_in(command, "state") : std::string(),
          time_in(status, "heard")};
}

LiveSource::Count LiveSource::count() const {
  Count count;
  space_.list({island_, prefix_ + ".*.*.status"}, [&](const tuples::TupleView& tuple) {
    ++count.devices;
    if (tuple.value.find("\"reachable\"") != tuple.value.npos) ++count.reachable;
  });
  return count;
}

std::string LiveSource::command_to_try() const {
  std::string first;
  space_.list({island_, prefix_ + ".*.*.actuator.*.command"}, [&](const tuples::TupleView& tuple) {
    if (!first.empty() && tuple.key > first) return;
    const auto point = without_last_part(tuple.key);
    if (text_in(parsed(value(point + ".description")), "data_type") == "boolean") first = tuple.key;
  });
  if (first.empty()) return "help, devices, quit";
  const auto point = without_last_part(first);
  const auto about = parsed(value(point + ".description"));
  std::vector<std::string> words{"off", "on"};
  if (const auto found = about.find("words"); found != about.end() && found->is_array() && found->size() == 2) {
    for (std::size_t i = 0; i < 2; ++i) {
      if ((*found)[i].is_string()) words[i] = (*found)[i].get<std::string>();
    }
  }
  return fmt::format("set {} {}", first, value(point + ".value") == words[1] ? words[0] : words[1]);
}

}  // namespace rubicon::console
