#include "proxy/tuple_mirror.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "base/prefetch.h"
#include "base/text.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::proxy {

namespace {

constexpr std::string_view kJsonType = "application/json";
constexpr Duration kRefreshPause = std::chrono::seconds(1);
/// Status texts written in one turn of the loop.
constexpr std::size_t kFlushSlice = 1000;

bool writable(const Point& point) {
  return point.id.kind == Kind::kActuator ||
         (point.id.kind == Kind::kProperty && point.details->capability->access != Access::kRead);
}

/// What a reader should know of a word that the point does not declare; empty for one that it does.
std::string mark_of(const Point& point, const Value& value) {
  const auto text = to_text(value);
  const auto& own = point.details->capability->words;
  const bool none = own.empty() && point.type->words.empty();
  const bool known = own.empty()
                         ? TypeCatalogue::names(*point.type, text)
                         : std::any_of(own.begin(), own.end(), [&](const auto& word) { return word.text == text; });
  return none || known ? std::string() : fmt::format("{} is not among the words of the point", model::quoted(text));
}

}  // namespace

TupleMirror::TupleMirror(ProxyContext& context, DeviceDirectory& directory, Memory& memory)
    : context_(context),
      directory_(directory),
      memory_(memory),
      event_end_(context.scheduler, [this] { end_events(); }),
      next_flush_(context.scheduler, [this] { flush(); }),
      last_flush_(context.clock.now().steady - kRefreshPause) {}

TupleRef TupleMirror::declare(std::string_view key, std::string_view value, std::string_view media_type,
                              WallTime user_time) {
  const auto made = context_.space.declare(key, value, {media_type, user_time, {}});
  if (made) return *made;
  context_.warn("declare", fmt::format("cannot declare tuple {}: {}", model::quoted(key), made.error().text));
  return {};
}

void TupleMirror::remember(TupleRef tuple, const Device& device) {
  if (tuple == TupleRef{}) return;
  if (tuple.index >= places_.size()) places_.resize(tuple.index + std::size_t{1});
  places_[tuple.index] = static_cast<std::uint32_t>(device.number);
}

TupleMirror::Place TupleMirror::place_of(TupleRef tuple) const {
  auto* device = tuple.index < places_.size() ? directory_.find_by_place(places_[tuple.index]) : nullptr;
  if (!device) return {};
  for (auto& point : device->points) {
    if (point.mirror.value == tuple) return {device, &point, false};
    if (point.mirror.command == tuple) return {device, &point, true};
  }
  return {};
}

void TupleMirror::joined(const DeviceDirectory::Joined& joined) {
  auto& device = *joined.device;
  for (const auto& point : joined.vanished) erase_point(device, point);
  if (joined.fresh) declare_device(device);
  if (!joined.changed) return;
  for (auto& point : device.points) {
    if (point.mirror.status == TupleRef{}) {
      declare_point(device, point);
    } else {
      std::ignore =
          context_.space.set(point_key(device, point).description(), point_description(point), {kJsonType, {}, {}});
    }
  }
  described(device);
}

void TupleMirror::described(const Device& device) {
  std::ignore =
      context_.space.set(model::DeviceKey{device.key}.description(), device_description(device), {kJsonType, {}, {}});
}

void TupleMirror::declare_device(Device& device) {
  device.mirror.status = declare(model::DeviceKey{device.key}.status(), device_status_text(device), kJsonType);
}

void TupleMirror::declare_point(Device& device, Point& point, const Kept* kept) {
  const auto key = point_key(device, point).value();
  point.mirror.value =
      kept ? declare(key, kept->value, kept->media_type, kept->user_time) : declare(key, {}, "text/plain");
  remember(point.mirror.value, device);
  write_point_status(device, point, status_text_);
  point.mirror.status = declare(point_key(device, point).status(), status_text_, kJsonType);
  declare(point_key(device, point).description(), point_description(point), kJsonType);
  if (writable(point)) {
    point.mirror.command = declare(point_key(device, point).command(), {}, "text/plain");
    remember(point.mirror.command, device);
  }
  if (!kept) initial_value(device, point);
}

void TupleMirror::initial_value(const Device& device, Point& point) {
  const auto& initial = point.details->capability->initial;
  if (std::holds_alternative<std::monostate>(initial) || is_event(point)) return;
  if (point.type && !TypeCatalogue::check(*point.type, initial)) return;
  own_value(device, point, initial, device.status == DeviceStatus::kReachable ? Quality::kGood : Quality::kStored);
}

void TupleMirror::added(Device& device, Point& point) {
  declare_point(device, point);
  described(device);
}

void TupleMirror::erase_point(const Device& device, const Point& point) {
  const auto point_tuples = point_key(device, point);
  for (const auto& key :
       {point_tuples.value(), point_tuples.status(), point_tuples.description(), point_tuples.command()})
    std::ignore = context_.space.erase(key);
}

void TupleMirror::left(Device& device) {
  for (const auto& point : device.points) erase_point(device, point);
  std::ignore = context_.space.erase(model::DeviceKey{device.key}.status());
  std::ignore = context_.space.erase(model::DeviceKey{device.key}.description());
}

std::map<PointNumber, TupleMirror::Kept> TupleMirror::retire(Device& device) {
  std::map<PointNumber, Kept> kept;
  for (const auto& point : device.points) {
    const auto tuple = context_.space.get(context_.space.self(), point_key(device, point).value());
    if (tuple) kept[point.number] = {std::string(tuple->value), std::string(tuple->media_type), tuple->user_time};
  }
  left(device);
  return kept;
}

void TupleMirror::renamed(Device& device, const std::map<PointNumber, Kept>& kept) {
  declare_device(device);
  for (auto& point : device.points) {
    const auto known = kept.find(point.number);
    declare_point(device, point, known == kept.end() ? nullptr : &known->second);
  }
  described(device);
}

void TupleMirror::remembered(const Device& device, Point& point, const state::StoredValue& stored) {
  if (is_event(point)) {
    point.heard = std::max(point.heard, stored.heard);
    point.changed = std::max(point.changed, stored.changed);
    return publish_status(device, point);
  }
  // A value that came with the join is newer.
  if (point.quality != Quality::kUnknown && point.quality != Quality::kStored) return;
  const auto* json = std::get_if<Json>(&stored.value);
  const auto text = json ? json->text : to_text(stored.value);
  if (point.type && !TypeCatalogue::parse_reading(*point.type, text)) return;
  point.mirror.text = text;
  point.heard = stored.heard;
  point.changed = stored.changed;
  std::ignore = context_.space.set(point.mirror.value, text, {media_type(stored.value), stored.user_time, {}});
  set_quality(device, point, Quality::kStored, "from before the restart");
}

void TupleMirror::device_status(const Device& device) {
  std::ignore = context_.space.set(device.mirror.status, device_status_text(device), {kJsonType, {}, {}});
}

void TupleMirror::all_points(Device& device) {
  for (auto& point : device.points) mark(device, point);
  schedule_flush(true);
}

void TupleMirror::fetch(const Point& point) const {
  base::prefetch(&point.heard_at);
  base::prefetch(&point.mirror.text);
  tuples::SpaceRights::fetch(context_.space, point.mirror.value);
}

bool TupleMirror::reading(Device& device, Point& point, const model::Reading& reading) {
  if (std::holds_alternative<std::monostate>(reading.value)) {
    bad_value(device, point, reading.why.empty() ? "the device has no value" : reading.why);
    return false;
  }
  if (point.type) {
    if (const auto fits = TypeCatalogue::check(*point.type, reading.value); !fits) [[unlikely]] {
      bad_value(device, point, fits.error().text);
      return false;
    }
  }
  if (point.mirror.doubted && !believes(device, point, reading.value)) [[unlikely]]
    return false;
  const auto& now = context_.clock.now();
  point.heard_at = now.steady;
  point.heard = now.wall;
  store_value(device, point, reading.value, reading.user_time);
  const bool was_good = point.quality == Quality::kGood;
  const bool has_words = point.type && point.type->data == model::DataType::kEnumeration;
  if (!was_good || has_words) [[unlikely]]
    set_quality(device, point, Quality::kGood, has_words ? mark_of(point, reading.value) : std::string());
  if (!was_good) return true;
  if (!point.mirror.dirty) {
    mark(device, point);
    schedule_flush(false);
  }
  return false;
}

/// A value that is stale or from before a restart says nothing of the next step.
bool TupleMirror::believes(const Device& device, Point& point, const Value& value) {
  const bool old = point.quality == Quality::kStale || point.quality == Quality::kStored;
  const bool comparable = point.details->plausibility->rules().rises || !old;
  const auto before = comparable ? base::parse_number<double>(point.mirror.text) : std::nullopt;
  auto why = point.details->plausibility->objection(value, before);
  if (why.empty()) return true;
  ++device.network->faults.implausible_values;
  refuse(device, point, why);
  return false;
}

void TupleMirror::store_value(const Device& device, Point& point, const Value& value, WallTime user_time) {
  write_value(point.type, value, value_text_);
  const bool event = is_event(point);
  if (event) end_later(device, point);
  Memory::note_value(point);
  if (event || point.mirror.text != value_text_) {
    point.mirror.text = value_text_;
    point.changed = context_.clock.now().wall;
  }
  std::ignore = context_.space.set(point.mirror.value, value_text_, {media_type(value), user_time, {}});
}

void TupleMirror::end_later(const Device& device, const Point& point) {
  const auto ends = context_.clock.now().steady + kEventLasts;
  events_[{device.number, point.number}] = ends;
  event_end_.advance_to(ends);
}

void TupleMirror::end_events() {
  context_.clock.refresh();
  const auto now = context_.clock.now().steady;
  auto next = SteadyTime::max();
  for (auto at = events_.begin(); at != events_.end();) {
    if (at->second > now) {
      next = std::min(next, at->second);
      ++at;
      continue;
    }
    auto* device = directory_.find(at->first.first);
    const auto* point = device ? find_point(*device, at->first.second) : nullptr;
    if (point) std::ignore = context_.space.set(point->mirror.value, {}, {});
    at = events_.erase(at);
  }
  event_end_.set_at(next);
}

/// A value is dated by its user time, or by when it arrived. One without a time replaces only what was stored before.
bool TupleMirror::is_news(const Device& device, const Point& point, const model::Reading& reading) const {
  if (point.quality == Quality::kGood && point.mirror.text == value_text_) return false;
  const bool stored = point.quality == Quality::kUnknown || point.quality == Quality::kStored;
  if (reading.user_time == WallTime{}) return stored;
  const auto shown = context_.space.get(context_.space.self(), point_key(device, point).value());
  const auto since = shown && shown->user_time != WallTime{} ? shown->user_time : point.heard;
  return stored ? reading.user_time >= since : reading.user_time > since;
}

void TupleMirror::repeated(const Device& device, Point& point, const model::Reading& reading) {
  if (is_event(point)) return;
  const bool fits = !point.type || TypeCatalogue::check(*point.type, reading.value);
  if (std::holds_alternative<std::monostate>(reading.value) || !fits) return;
  if (point.details->plausibility && !point.details->plausibility->objection(reading.value, std::nullopt).empty())
    return;
  write_value(point.type, reading.value, value_text_);
  if (!is_news(device, point, reading)) return;
  store_value(device, point, reading.value, reading.user_time);
  set_quality(device, point, Quality::kStored, "remembered by the network");
}

void TupleMirror::bad_value(const Device& device, Point& point, const std::string& why) {
  ++device.network->faults.bad_values;
  refuse(device, point, why);
}

void TupleMirror::refuse(const Device& device, Point& point, const std::string& why) {
  context_.warn(device.key, fmt::format("{}: {}: {}", device.key, point.details->id(), why));
  set_quality(device, point, Quality::kBad, why);
}

void TupleMirror::assume(const Device& device, Point& point, const Value& value) {
  store_value(device, point, value, {});
  set_quality(device, point, Quality::kAssumed, "commanded; the actuator does not report");
}

void TupleMirror::own_value(const Device& device, Point& point, const Value& value, Quality quality) {
  const auto& now = context_.clock.now();
  store_value(device, point, value, {});
  point.heard_at = now.steady;
  if (quality == Quality::kGood) point.heard = now.wall;
  set_quality(device, point, quality, {});
}

void TupleMirror::set_quality(const Device& device, Point& point, Quality quality, std::string reason) {
  if (point.quality != quality) point.since = context_.clock.now().wall;
  const bool same = point.quality == quality && point.details->reason == reason;
  point.quality = quality;
  point.details->reason = std::move(reason);
  if (!same) publish_status(device, point);
}

void TupleMirror::publish_status(const Device& device, Point& point) {
  point.mirror.dirty = false;
  memory_.values_changed(device.number);
  write_point_status(device, point, status_text_);
  std::ignore = context_.space.set(point.mirror.status, status_text_, {kJsonType, {}, {}});
}

void TupleMirror::mark(Device& device, Point& point) {
  point.mirror.dirty = true;
  if (device.mirror.dirty) return;
  device.mirror.dirty = true;
  dirty_.push_back(device.number);
}

void TupleMirror::schedule_flush(bool at_once) {
  urgent_ |= at_once;
  const auto now = context_.clock.now().steady;
  next_flush_.advance_to(at_once ? now : std::max(now, last_flush_ + kRefreshPause));
}

void TupleMirror::flush() {
  context_.clock.refresh();
  if (flushing_.empty()) {
    flushing_.swap(dirty_);
    urgent_ = false;
  }
  std::size_t written = 0;
  while (!flushing_.empty() && written < kFlushSlice) {
    auto* device = directory_.find(flushing_.back());
    flushing_.pop_back();
    if (!device) continue;
    device->mirror.dirty = false;
    for (auto& point : device->points) {
      if (!point.mirror.dirty) continue;
      publish_status(*device, point);
      ++written;
    }
  }
  last_flush_ = context_.clock.now().steady;
  if (!flushing_.empty()) {
    schedule_flush(true);
  } else if (!dirty_.empty()) {
    schedule_flush(urgent_);
  }
}

}  // namespace rubicon::proxy
