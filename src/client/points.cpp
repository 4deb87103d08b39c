#include "client/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "base/natural_order.h"
#include "client/device_watch.h"
#include "rubicon/key.hpp"

namespace rubicon::client {

namespace {

constexpr std::size_t kPointParts = 5;

/// What several tuples say, by owner and key.
using Texts = std::map<std::pair<OwnerId, std::string_view>, const Tuple*>;

std::string_view text_at(const Texts& texts, OwnerId owner, const std::string& key) {
  const auto found = texts.find({owner, key});
  return found == texts.end() ? std::string_view() : std::string_view(found->second->value);
}

bool in_natural_order(OwnerId island_a, std::string_view a, OwnerId island_b, std::string_view b) {
  if (island_a != island_b) return island_a < island_b;
  return base::natural_less(a, b);
}

Point point_from(const Tuple& tuple, const Texts& texts) {
  Point point;
  point.tuple = tuple;
  const model::PointKey key{point.key()};
  point.status = model::point_status_from_json(text_at(texts, tuple.owner, key.status()));
  point.line = model::line_status_from_json(text_at(texts, tuple.owner, line_key(tuple.key)));
  describe(point, text_at(texts, tuple.owner, key.description()));
  if (!tuple.owner_present) hide_behind_lost_island(point);
  return point;
}

int rank_of(const Device& device) {
  if (device.status == "reachable") return 0;
  return device.status == "unreachable" ? 1 : 2;
}

}  // namespace

Result<PointPatterns> point_patterns(const Pattern& points) {
  const auto parts = model::key_parts(points.key);
  if (parts.size() != kPointParts || parts.back() == "**")
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected a point, a key of five parts such as "
                                                 "proxy.wsn-1.7.sensor.light-1, * for any one part",
                                                 model::quoted(points.key)));
  const auto pattern = [&points](const std::string& key) { return Pattern{points.owner, key}; };
  const model::PointKey point{points.key};
  return PointPatterns{pattern(point.value()), pattern(point.status()), pattern(point.description()),
                       pattern(line_key(points.key))};
}

std::string line_key(std::string_view key) {
  const auto network = model::network_of(key);
  return network ? network->status() : std::string();
}

void describe(Point& point, std::string_view description) {
  auto about = model::point_description_from_json(description).value_or(model::PointDescription{});
  point.type = std::move(about.type);
  point.unit = std::move(about.unit);
  point.is_event = about.report == "event";
}

void hide_behind_lost_island(Point& point) {
  if (point.status.quality.empty()) return;
  point.status.quality = "network-down";
  point.status.reason = fmt::format("island {} is not there", number(point.tuple.owner));
  point.line = {};
}

std::vector<Point> points_from(const std::vector<Tuple>& tuples) {
  Texts texts;
  for (const auto& tuple : tuples) texts[{tuple.owner, tuple.key}] = &tuple;
  std::vector<Point> points;
  for (const auto& tuple : tuples) {
    if (tuple.key.ends_with(".value") && model::key_parts(tuple.key).size() == kPointParts + 1)
      points.push_back(point_from(tuple, texts));
  }
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return in_natural_order(a.tuple.owner, a.tuple.key, b.tuple.owner, b.tuple.key);
  });
  return points;
}

std::vector<Device> devices_from(const std::vector<Tuple>& tuples, const DeviceQuery& query) {
  Texts texts;
  for (const auto& tuple : tuples) texts[{tuple.owner, tuple.key}] = &tuple;
  std::vector<Device> found;
  for (const auto& tuple : tuples) {
    if (!tuple.key.ends_with(".description")) continue;
    auto device = device_from(tuple.owner, tuple.key, tuple.value);
    if (!device || !fits(query, *device)) continue;
    auto condition =
        model::device_condition_from_json(text_at(texts, tuple.owner, model::DeviceKey{device->key()}.status()));
    device->status = std::move(condition.status);
    device->reason = std::move(condition.reason);
    device->since = condition.since;
    device->line = model::line_status_from_json(text_at(texts, tuple.owner, line_key(tuple.key)));
    found.push_back(std::move(*device));
  }
  return found;
}

std::vector<Network> networks_from(const std::vector<Tuple>& tuples) {
  std::map<std::tuple<OwnerId, std::string, std::string>, Network> found;
  for (const auto& tuple : tuples) {
    const auto parts = model::key_parts(tuple.key);
    if (parts.size() != 3 || parts[2] != "status") continue;
    auto line = model::line_status_from_json(tuple.value);
    if (line.line.empty()) continue;
    const std::string prefix(parts[0]), id(parts[1]);
    found[{tuple.owner, prefix, id}] = {tuple.owner, prefix, id, std::move(line), 0, 0, {}};
  }
  for (const auto& tuple : tuples) {
    const auto parts = model::key_parts(tuple.key);
    if (parts.size() < 4) continue;
    const auto network = found.find({tuple.owner, std::string(parts[0]), std::string(parts[1])});
    if (network == found.end()) continue;
    auto& one = network->second;
    if (parts.size() == 4 && parts[3] == "status") {
      ++one.devices;
      if (model::device_condition_from_json(tuple.value).status == "reachable") ++one.reachable;
    } else if (parts.size() == 5 && parts[2] == "property" && parts[4] == "value") {
      one.properties[std::string(parts[3])] = tuple.value;
    }
  }
  std::vector<Network> networks;
  for (auto& entry : found) networks.push_back(std::move(entry.second));
  std::sort(networks.begin(), networks.end(),
            [](const Network& a, const Network& b) { return in_natural_order(a.island, a.id, b.island, b.id); });
  return networks;
}

bool listed_before(const Device& a, const Device& b) {
  const auto place = [](const Device& device) { return std::tuple(rank_of(device), device.island); };
  if (place(a) != place(b)) return place(a) < place(b);
  if (a.network != b.network) return base::natural_less(a.network, b.network);
  return base::natural_less(a.id, b.id);
}

}  // namespace rubicon::client
