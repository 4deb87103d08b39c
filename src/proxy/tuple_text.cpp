#include "proxy/tuple_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "model/point.h"
#include "model/point_tuples.h"

namespace rubicon::proxy {

namespace {

/// The reason that belongs to the quality shown, and since when it holds.
std::pair<std::string_view, WallTime> reason_of(const Device& device, const Point& point) {
  if (device.network->down) return {device.network->reason, device.network->since};
  if (device.status == DeviceStatus::kUnreachable) return {device.reason.text(), device.since};
  std::string_view reason = point.details->reason.text();
  if (reason.empty() && point.demand.wanted && point.quality != Quality::kGood) reason = device.sampling.refusal.text();
  return {reason, point.since};
}

std::optional<double> bound_of(std::optional<double> own, double of_type) {
  const double bound = own.value_or(of_type);
  return std::isfinite(bound) ? std::optional(bound) : std::nullopt;
}

/// One of the counters that came with the state of the line.
std::uint64_t reported_number(const Network& network, const char* name) {
  const auto found = network.reported.find(name);
  if (found == network.reported.end()) return 0;
  return base::parse_number<std::uint64_t>(found->second).value_or(0);
}

}  // namespace

void write_value(const Type* type, const Value& value, std::string& out) {
  const auto* on = std::get_if<bool>(&value);
  if (!on || !type || type->words.empty()) return to_text(value, out);
  const auto comma = std::min(type->words.find(','), type->words.size() - 1);
  out = *on ? type->words.substr(comma + 1) : type->words.substr(0, comma);
}

std::string seconds_text(Duration span) {
  const auto rounded = std::chrono::round<std::chrono::milliseconds>(span);
  return fmt::format("{:g} s", std::chrono::duration<double>(rounded).count());
}

void write_point_status(const Device& device, const Point& point, std::string& out) {
  const auto [reason, since] = reason_of(device, point);
  model::write_point_status({to_string(shown_quality(device, point)), reason, since, point.heard, point.changed,
                             point.details->last_command.text(), point.details->ended_commands.text()},
                            out);
}

std::string device_status_text(const Device& device) {
  return model::device_condition_to_json(
      DeviceCondition{std::string(to_string(device.status)), device.reason.text(), device.since});
}

std::string network_status_text(const Network& network) {
  return model::line_status_to_json(LineStatus{
      std::string(to_string(network.line)), network.reason, network.since, reported_number(network, "attempts"),
      WallTime(std::chrono::seconds(reported_number(network, "next-attempt"))), network.finding});
}

std::string point_description(const Point& point) {
  const auto& capability = *point.details->capability;
  const model::Type unknown{};
  const auto& type = point.type ? *point.type : unknown;
  const auto& id = point.details->id();
  model::PointDescription description;
  description.type = point.type ? std::string(type.name) : model::name_in_keys(capability);
  description.type_id = static_cast<std::uint64_t>(point.id.type);
  description.quantity = type.quantity;
  description.unit = capability.unit.empty() ? std::string(type.unit) : capability.unit;
  description.data_type = point.type ? to_string(type.data) : std::string_view("unknown");
  description.minimum = bound_of(capability.minimum, type.minimum);
  description.maximum = bound_of(capability.maximum, type.maximum);
  description.words = capability.words.empty() ? model::words_in(type.words) : capability.words;
  description.access = to_string(capability.access);
  description.report = is_event(point) ? "event" : "state";
  description.instance = id.substr(std::min(id.find('-'), id.size() - 1) + 1);
  return model::point_description_to_json(description);
}

std::string device_description(const Device& device) {
  model::DeviceDescription description{device.name,
                                       std::string(device.area.text()),
                                       device.model,
                                       device.type,
                                       device.address,
                                       device.network->id,
                                       {},
                                       {},
                                       {},
                                       {}};
  std::vector<std::string>* lists[] = {&description.sensors, &description.actuators, &description.properties};
  auto& capabilities = description.capabilities;
  for (const auto& point : device.points) {
    const auto& id = point.details->id();
    lists[static_cast<std::size_t>(point.id.kind)]->push_back(id);
    auto type = id.substr(0, id.find('-'));
    if (std::find(capabilities.begin(), capabilities.end(), type) == capabilities.end())
      capabilities.push_back(std::move(type));
  }
  return model::device_description_to_json(description);
}

void append_reachable(const Network& network, std::string_view before, std::string& list) {
  for (const auto* device : network.by_id) {
    if (device->status != DeviceStatus::kReachable) continue;
    if (list.size() > 1) list += ',';
    list += '"';
    list += before;
    list += device->id;  // a key part needs no escapes
    list += '"';
  }
}

std::string reachable_devices(const Network& network) {
  std::string out = "[";
  append_reachable(network, {}, out);
  return out + ']';
}

}  // namespace rubicon::proxy
