#include "client/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/compare_text.h"
#include "rubicon/key.hpp"

namespace rubicon::client {

namespace {

constexpr std::size_t kPointParts = 5;

struct NameHash {
  std::size_t operator()(const std::pair<OwnerId, std::string_view>& name) const {
    return std::hash<std::string_view>{}(name.second) + number(name.first) * 0x9e3779b97f4a7c15u;
  }
};
/// What several tuples say, by owner and key.
using Texts = std::unordered_map<std::pair<OwnerId, std::string_view>, const Tuple*, NameHash>;

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

std::vector<Device> described_devices(const std::vector<Tuple>& tuples, const DeviceQuery& query) {
  std::vector<Device> found;
  for (const auto& tuple : tuples) {
    if (!tuple.key.ends_with(".description")) continue;
    auto device = device_from(tuple.owner, tuple.key, tuple.value);
    if (device && fits(query, *device)) found.push_back(std::move(*device));
  }
  return found;
}

void add_states(std::vector<Device>& devices, const std::vector<Tuple>& tuples) {
  Texts texts;
  for (const auto& tuple : tuples) {
    if (tuple.key.ends_with(".status")) texts[{tuple.owner, tuple.key}] = &tuple;
  }
  std::map<std::pair<OwnerId, std::string>, LineStatus> lines;
  for (auto& device : devices) {
    const model::DeviceKey key{device.key()};
    auto condition = model::device_condition_from_json(text_at(texts, device.island, key.status()));
    device.status = std::move(condition.status);
    device.reason = std::move(condition.reason);
    device.since = condition.since;
    const auto [line, fresh] = lines.try_emplace({device.island, line_key(key.text)});
    if (fresh) line->second = model::line_status_from_json(text_at(texts, device.island, line->first.second));
    device.line = line->second;
  }
}

std::vector<Device> devices_from(const std::vector<Tuple>& tuples, const DeviceQuery& query) {
  auto found = described_devices(tuples, query);
  add_states(found, tuples);
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

namespace {

constexpr std::size_t kSnapshots = 4;
/// Of a value, after its owner sent it.
constexpr Duration kOnItsWay = std::chrono::milliseconds(250);

/// What a reader has to know; times alone are no news.
bool same(const PointStatus& a, const PointStatus& b) {
  return a.quality == b.quality && a.reason == b.reason;
}
bool same(const LineStatus& a, const LineStatus& b) {
  return a.line == b.line && a.reason == b.reason;
}

}  // namespace

PointWatch::PointWatch(Scheduler& scheduler, TupleSpace& space, const PointPatterns& patterns, const Flow& flow,
                       PointCall call)
    : scheduler_(scheduler),
      space_(space),
      hold_(flow.minimum > Duration(0) ? flow.minimum + kOnItsWay : Duration(0)),
      call_(std::move(call)) {
  const Flow passive{.passive = true};
  const auto follow = [this](const Pattern& pattern, const Flow& pace, void (PointWatch::*take)(const tuples::Event&)) {
    handles_.push_back(space_.subscribe(
        pattern, pace, [this, take](const tuples::Event& event) { (this->*take)(event); },
        [this](OwnerId owner) { arrived(owner); }));
  };
  follow(patterns.lines, passive, &PointWatch::line_stated);
  follow(patterns.descriptions, passive, &PointWatch::described);
  follow(patterns.statuses, passive, &PointWatch::stated);
  follow(patterns.values, flow, &PointWatch::valued);
  handles_.push_back(
      space_.watch_peers([this](OwnerId owner, tuples::PeerEvent event) { peer_changed(owner, event); }));
}

void PointWatch::valued(const tuples::Event& event) {
  const Name name{event.tuple.owner, std::string(model::parent_key(event.tuple.key))};
  if (event.kind != tuples::EventKind::kSet) {
    auto gone = entries_.extract(name);
    touched_.erase(name);
    if (gone) gone.mapped().point.tuple.owner_present = event.kind != tuples::EventKind::kLost;
    if (gone && gone.mapped().reported) call_(PointEvent::kRemoved, shown(name, gone.mapped()));
    return forget_lost(name.first);
  }
  auto& entry = entries_[name];
  if (!entry.has_value) note_if_lost(event.tuple);
  if (entry.fresh) std::ignore = report(name, entry);  // two sets within a turn are two events
  entry.point.tuple = Tuple(event.tuple);
  entry.has_value = entry.fresh = true;
  touch(name);
}

void PointWatch::stated(const tuples::Event& event) {
  if (event.kind != tuples::EventKind::kSet) return;
  const Name name{event.tuple.owner, std::string(model::parent_key(event.tuple.key))};
  auto& entry = entries_[name];
  auto status = model::point_status_from_json(event.tuple.value);
  const bool improved = status.quality == "good" && entry.point.status.quality != "good";
  entry.point.status = std::move(status);
  if (improved) entry.improved_at = scheduler_.now();
  touch(name);
}

void PointWatch::described(const tuples::Event& event) {
  if (event.kind != tuples::EventKind::kSet) return;
  describe(entries_[{event.tuple.owner, std::string(model::parent_key(event.tuple.key))}].point, event.tuple.value);
}

void PointWatch::line_stated(const tuples::Event& event) {
  const Name line{event.tuple.owner, std::string(event.tuple.key)};
  if (event.kind != tuples::EventKind::kSet) return void(lines_.erase(line));
  auto status = model::line_status_from_json(event.tuple.value);
  if (status.line.empty()) return;  // a tuple of three parts that is not a line
  const bool news = !same(std::exchange(lines_[line], status), status);
  const auto below = std::string(model::parent_key(line.second)) + ".";
  for (auto at = entries_.lower_bound({line.first, below});
       news && at != entries_.end() && at->first.first == line.first && at->first.second.starts_with(below); ++at)
    touch(at->first);
}

void PointWatch::arrived(OwnerId owner) {
  if (++arrived_[owner] >= kSnapshots && !touched_.empty()) settle_at(scheduler_.now());
}

void PointWatch::peer_changed(OwnerId owner, tuples::PeerEvent event) {
  if (event == tuples::PeerEvent::kUp) {
    lost_.erase(owner);
  } else {
    lost_.insert(owner);
    arrived_.erase(owner);
  }
  for (auto at = entries_.lower_bound({owner, {}}); at != entries_.end() && at->first.first == owner; ++at)
    touch(at->first);
  forget_lost(owner);
}

/// A copy from an owner that was lost before this watch began: neither a snapshot nor the loss is reported.
void PointWatch::note_if_lost(const tuples::TupleView& tuple) {
  const auto now = space_.get(tuple.owner, tuple.key);
  if (now && !now->owner_present) lost_.insert(tuple.owner);
}

/// None of its points is shown from now on.
void PointWatch::forget_lost(OwnerId owner) {
  const auto first = entries_.lower_bound({owner, {}});
  if (first == entries_.end() || first->first.first != owner) lost_.erase(owner);
}

void PointWatch::touch(const Name& name) {
  touched_.insert(name);
  settle_at(scheduler_.now());
}

void PointWatch::settle_at(SteadyTime when) {
  if (timer_.pending() && settle_at_ <= when) return;
  settle_at_ = when;
  timer_ = scheduler_.at(when, [this] { settle(); });
}

void PointWatch::settle() {
  auto later = SteadyTime::max();
  for (const auto& name : std::exchange(touched_, {})) {
    const auto found = entries_.find(name);
    if (found == entries_.end() || report(name, found->second)) continue;
    touched_.insert(name);
    if (complete(name.first)) later = std::min(later, *found->second.improved_at + hold_);
  }
  if (later != SteadyTime::max()) settle_at(later);
}

bool PointWatch::report(const Name& name, Entry& entry) {
  if (!entry.has_value) return true;  // it is reported with its value
  if (!complete(name.first)) return false;
  if (entry.point.is_event && entry.point.tuple.value.empty()) entry.fresh = false;  // it is over, or none came yet
  const auto point = shown(name, entry);
  const bool news = !same(point.status, entry.shown_status) || !same(point.line, entry.shown_line);
  if (!entry.fresh && !news) return true;
  const bool held_back = entry.improved_at && scheduler_.now() < *entry.improved_at + hold_;
  if (!entry.fresh && entry.reported && point.good() && held_back) return false;
  const auto event = std::exchange(entry.fresh, false) ? PointEvent::kValue : PointEvent::kState;
  entry.reported = true;
  entry.improved_at.reset();
  entry.shown_status = point.status;
  entry.shown_line = point.line;
  call_(event, point);
  return true;
}

bool PointWatch::complete(OwnerId owner) const {
  if (owner == space_.self() || lost_.contains(owner)) return true;
  const auto found = arrived_.find(owner);
  return found != arrived_.end() && found->second >= kSnapshots;
}

Point PointWatch::shown(const Name& name, const Entry& entry) const {
  auto point = entry.point;
  const auto line = lines_.find({name.first, line_key(name.second)});
  if (line != lines_.end()) point.line = line->second;
  if (lost_.contains(name.first)) hide_behind_lost_island(point);
  return point;
}

}  // namespace rubicon::client
