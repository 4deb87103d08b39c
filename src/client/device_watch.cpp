#include "client/points.h"

#include <algorithm>

#include "base/compare_text.h"
#include "model/type_names.h"

namespace rubicon::client {

namespace {

bool any_or_matches(const std::string& pattern, std::string_view text) {
  return pattern.empty() || base::glob_matches(pattern, text);
}

/// `temperature-window` is a `temperature`; former names count on both sides.
bool has_point(const std::vector<std::string>& points, const std::string& type) {
  const auto wanted = model::current_type(type);
  return std::any_of(points.begin(), points.end(), [&](const std::string& id) {
    return base::glob_matches(wanted, model::current_type(std::string_view(id).substr(0, id.find('-'))));
  });
}

/// The longest part of a pattern that stands in JSON as it is.
std::string_view plain_part(std::string_view pattern) {
  const auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '*' && c != '?' && c != '"' && c != '\\'; };
  std::string_view longest;
  for (std::size_t at = 0, begin = 0; at <= pattern.size(); ++at) {
    if (at < pattern.size() && is_plain(pattern[at])) continue;
    if (at - begin > longest.size()) longest = pattern.substr(begin, at - begin);
    begin = at + 1;
  }
  return longest;
}

constexpr Flow kPassive{.passive = true};

}  // namespace

Result<Device> device_from(OwnerId island, std::string_view key, std::string_view description) {
  const auto parts = model::key_parts(key);
  if (parts.size() != 4) return fail(ErrorCode::kInvalid, "description of a device: expected a key of four parts");
  auto about = model::device_description_from_json(description);
  if (!about) return fail(ErrorCode::kInvalid, "description of a device: expected a JSON object");
  Device device;
  device.island = island;
  device.prefix = parts[0];
  device.network = parts[1];
  device.id = parts[2];
  device.name = std::move(about->name);
  device.model = std::move(about->model);
  device.type = std::move(about->type);
  device.address = std::move(about->address);
  device.area = std::move(about->area);
  device.sensors = std::move(about->sensors);
  device.actuators = std::move(about->actuators);
  device.properties = std::move(about->properties);
  return device;
}

bool fits(const DeviceQuery& query, const Device& device) {
  if (query.island && *query.island != device.island) return false;
  if (!any_or_matches(query.network, device.network) || !any_or_matches(query.area, device.area)) return false;
  const bool name_fits = any_or_matches(query.name, device.name) || any_or_matches(query.name, device.id) ||
                         any_or_matches(query.name, device.address);
  const bool type_fits = any_or_matches(query.type, device.type) || has_point(device.sensors, query.type) ||
                         has_point(device.actuators, query.type) || has_point(device.properties, query.type);
  return name_fits && type_fits;
}

bool may_fit(const DeviceQuery& query, std::string_view key, std::string_view description) {
  if (description.find('\\') != description.npos) return true;  // a letter may be written as a number
  const auto has = [](std::string_view text, std::string_view part) { return text.find(part) != text.npos; };
  const auto name = plain_part(query.name);
  return has(description, plain_part(query.area)) && (has(description, name) || has(key, name));
}

DeviceWatch::DeviceWatch(TupleSpace& space, DeviceQuery query, DeviceCall call)
    : query_(std::move(query)), call_(std::move(call)) {
  const auto any_network = model::IslandKey{"*"}.network("*");
  const auto any_device = any_network.device("*");
  lines_watch_ = space.subscribe({query_.island, any_network.status()}, kPassive,
                                 [this](const Event& event) { line_stated(event); });
  statuses_ =
      space.subscribe({query_.island, any_device.status()}, kPassive, [this](const Event& event) { stated(event); });
  descriptions_ = space.subscribe({query_.island, any_device.description()}, kPassive,
                                  [this](const Event& event) { described(event); });
}

void DeviceWatch::described(const Event& event) {
  const Name name{event.tuple.owner, std::string(model::parent_key(event.tuple.key))};
  if (event.kind != EventKind::kSet) return forget(name);
  auto device = device_from(event.tuple.owner, event.tuple.key, event.tuple.value);
  if (!device) return;
  auto& entry = entries_[name];
  entry.device = std::move(*device);
  report(entry);
}

void DeviceWatch::stated(const Event& event) {
  const Name name{event.tuple.owner, std::string(model::parent_key(event.tuple.key))};
  if (event.kind != EventKind::kSet) return forget(name);
  auto& entry = entries_[name];
  auto condition = model::device_condition_from_json(event.tuple.value);
  const auto& known = entry.condition;
  const bool same = known.status == condition.status && known.reason == condition.reason;
  entry.condition = std::move(condition);
  if (!entry.reported || !same) report(entry);
}

void DeviceWatch::line_stated(const Event& event) {
  const Name network{event.tuple.owner, std::string(model::parent_key(event.tuple.key))};
  if (event.kind != EventKind::kSet) return void(lines_.erase(network));
  auto line = model::line_status_from_json(event.tuple.value);
  if (line.line.empty()) return;  // a tuple of three parts that is not a line
  const auto& [island, key] = network;
  auto& known = lines_[network];
  const bool same = known.line == line.line && known.reason == line.reason;
  known = std::move(line);
  if (same) return;
  const auto below = key + ".";
  for (auto at = entries_.lower_bound({island, below}); at != entries_.end(); ++at) {
    if (std::get<0>(at->first) != island || !std::get<1>(at->first).starts_with(below)) break;
    report(at->second);
  }
}

void DeviceWatch::report(Entry& entry) {
  if (!entry.device || entry.condition.status.empty()) return;
  auto& about = *entry.device;
  about.status = entry.condition.status;
  about.reason = entry.condition.reason;
  about.since = entry.condition.since;
  if (const auto line = lines_.find({about.island, model::IslandKey{about.prefix}.network(about.network).text});
      line != lines_.end())
    about.line = line->second;
  const bool wanted = fits(query_, *entry.device);
  if (!wanted && !entry.reported) return;
  entry.reported = wanted;
  const auto device = *entry.device;
  call_(device, wanted);
}

void DeviceWatch::forget(const Name& name) {
  const auto gone = entries_.extract(name);
  if (gone && gone.mapped().reported && gone.mapped().device) call_(*gone.mapped().device, false);
}

}  // namespace rubicon::client
