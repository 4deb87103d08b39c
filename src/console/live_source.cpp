#include "console/live_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/natural_order.h"
#include "rubicon/key.hpp"
#include "rubicon/unit.hpp"

namespace rubicon::console {

namespace {

std::string part_of(std::string_view key, std::size_t index) {
  const auto parts = model::key_parts(key);
  return index < parts.size() ? std::string(parts[index]) : std::string();
}

}  // namespace

LiveSource::LiveSource(const TupleSpace& space, OwnerId island, std::string prefix)
    : space_(space), island_(island), prefix_(std::move(prefix)) {}

model::DeviceKey LiveSource::any_device() const {
  return model::IslandKey{prefix_}.network("*").device("*");
}

std::string LiveSource::value(const std::string& key) const {
  const auto tuple = space_.get(island_, key);
  return tuple ? std::string(tuple->value) : std::string();
}

std::vector<LiveNetwork> LiveSource::networks() const {
  std::vector<LiveNetwork> all;
  space_.list({island_, model::IslandKey{prefix_}.network("*").status()}, [&](const tuples::TupleView& tuple) {
    auto status = model::line_status_from_json(tuple.value);
    if (model::is_of_island(tuple.key)) return;
    all.push_back({part_of(tuple.key, 1), std::move(status.line), std::move(status.reason)});
  });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return base::natural_less(a.id, b.id); });
  return all;
}

std::vector<std::string> LiveSource::devices() const {
  std::vector<std::string> keys;
  space_.list({island_, any_device().status()}, [&](const tuples::TupleView& tuple) {
    if (!model::is_of_island(tuple.key)) keys.emplace_back(model::parent_key(tuple.key));
  });
  std::sort(keys.begin(), keys.end(), base::natural_less);
  return keys;
}

LiveDevice LiveSource::device(const std::string& key) const {
  const model::DeviceKey device{key};
  auto condition = model::device_condition_from_json(value(device.status()));
  auto description = model::device_description_from_json(value(device.description()));
  return {key,
          part_of(key, 1),
          part_of(key, 2),
          description ? std::move(description->name) : std::string(),
          std::move(condition.status),
          std::move(condition.reason)};
}

std::vector<std::string> LiveSource::points(const std::string& device) const {
  std::vector<std::string> keys;
  for (const auto* kind : {"sensor", "actuator"}) {
    const auto begin = static_cast<std::ptrdiff_t>(keys.size());
    space_.list({island_, model::DeviceKey{device}.point(kind, "*").value()},
                [&](const tuples::TupleView& tuple) { keys.emplace_back(model::parent_key(tuple.key)); });
    std::sort(keys.begin() + begin, keys.end(), base::natural_less);
  }
  return keys;
}

model::PointDescription LiveSource::description(const model::PointKey& point) const {
  return model::point_description_from_json(value(point.description())).value_or(model::PointDescription{});
}

LivePoint LiveSource::point(const std::string& key) const {
  const model::PointKey point{key};
  auto status = model::point_status_from_json(value(point.status()));
  return {key,
          part_of(key, 4),
          value(point.value()),
          model::unit_text(description(point).unit),
          std::move(status.quality),
          std::move(status.command),
          status.heard};
}

LiveSource::Count LiveSource::count() const {
  Count count;
  space_.list({island_, any_device().status()}, [&](const tuples::TupleView& tuple) {
    if (model::is_of_island(tuple.key)) return;
    ++count.devices;
    if (model::says_reachable(tuple.value)) ++count.reachable;
  });
  return count;
}

std::string LiveSource::command_to_try() const {
  std::string first;
  space_.list({island_, any_device().point(Kind::kActuator, "*").command()}, [&](const tuples::TupleView& tuple) {
    if (!first.empty() && tuple.key > first) return;
    const model::PointKey point{std::string(model::parent_key(tuple.key))};
    if (description(point).data_type == "boolean") first = tuple.key;
  });
  if (first.empty()) return "help, devices, quit";
  const model::PointKey point{std::string(model::parent_key(first))};
  const auto words = description(point).words;
  const bool has_words = words.size() == 2;
  const std::string off = has_words ? words[0].text : "off", on = has_words ? words[1].text : "on";
  return fmt::format("set {} {}", first, value(point.value()) == on ? off : on);
}

}  // namespace rubicon::console
