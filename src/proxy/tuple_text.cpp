#include "proxy/tuple_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "model/point_tuples.h"

namespace rubicon::proxy {

namespace {

using Tree = nlohmann::ordered_json;

std::string dump(const Tree& tree) {
  return tree.dump(-1, ' ', false, Tree::error_handler_t::replace);
}

/// The reason that belongs to the quality shown, and since when it holds.
std::pair<std::string_view, WallTime> reason_of(const Device& device, const Point& point) {
  if (device.network->down) return {device.network->reason, device.network->since};
  if (device.status == DeviceStatus::kUnreachable) return {device.reason.text(), device.since};
  std::string_view reason = point.details->reason.text();
  if (reason.empty() && point.wanted && point.quality != Quality::kGood) reason = device.sampling.refusal.text();
  return {reason, point.since};
}

Tree words_of(std::string_view words) {
  Tree list = Tree::array();
  while (!words.empty()) {
    const auto comma = words.find(',');
    list.push_back(words.substr(0, comma));
    words.remove_prefix(comma == words.npos ? words.size() : comma + 1);
  }
  return list;
}

/// The words of a point itself; their numbers too where these are not 0, 1, 2 and so on.
void add_words(Tree& tree, const std::vector<model::Word>& words) {
  Tree texts = Tree::array(), codes = Tree::array();
  bool counted = true;
  for (const auto& word : words) {
    counted = counted && word.value == codes.size();
    texts.push_back(word.text);
    codes.push_back(word.value);
  }
  tree["words"] = std::move(texts);
  if (!counted) tree["codes"] = std::move(codes);
}

void add_range(Tree& tree, const char* name, std::optional<double> own, double of_type) {
  const double bound = own.value_or(of_type);
  if (std::isfinite(bound)) tree[name] = bound;
}

/// One of the counters that came with the state of the line.
std::uint64_t reported_number(const Network& network, const char* name) {
  const auto found = network.reported.find(name);
  if (found == network.reported.end()) return 0;
  std::uint64_t number = 0;
  const auto& text = found->second;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
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

void append_seconds(WallTime time, std::string& out) {
  const auto micros = time.time_since_epoch().count();
  fmt::format_to(std::back_inserter(out), "{}", micros / 1000000);
  auto rest = micros % 1000000;
  if (rest <= 0) return;
  int digits = 6;
  for (; rest % 10 == 0; rest /= 10) --digits;
  fmt::format_to(std::back_inserter(out), ".{:0{}}", rest, digits);
}

void append_json(std::string_view text, std::string& out) {
  if (text.empty()) {
    out += "\"\"";
    return;
  }
  out += dump(Tree(text));
}

void write_point_status(const Device& device, const Point& point, std::string& out) {
  const auto [reason, since] = reason_of(device, point);
  out = "{\"quality\":\"";
  out += to_string(shown_quality(device, point));
  out += "\",\"since\":";
  append_seconds(since, out);
  out += ",\"heard\":";
  append_seconds(point.heard, out);
  out += ",\"changed\":";
  append_seconds(point.changed, out);
  out += ",\"reason\":";
  append_json(reason, out);
  if (!point.details->command.empty()) {
    out += ",\"command\":";
    out += point.details->command.text();
  }
  out += '}';
}

std::string device_status_text(const Device& device) {
  return model::device_condition_to_json(
      DeviceCondition{std::string(to_string(device.status)), device.reason.text(), device.since});
}

std::string network_status_text(const Network& network) {
  return model::line_status_to_json(LineStatus{
      std::string(to_string(network.line)), network.reason, network.since, reported_number(network, "attempts"),
      WallTime(std::chrono::seconds(reported_number(network, "next-attempt")))});
}

std::string point_description(const Point& point) {
  const auto& capability = *point.details->capability;
  const model::Type unknown{};
  const auto& type = point.type ? *point.type : unknown;
  Tree tree;
  tree["type"] = point.type ? std::string(type.name) : capability.type_name;
  tree["type_id"] = static_cast<unsigned>(point.id.type);
  tree["quantity"] = type.quantity;
  tree["unit"] = capability.unit.empty() ? std::string(type.unit) : capability.unit;
  tree["data_type"] = point.type ? to_string(type.data) : std::string_view("unknown");
  add_range(tree, "minimum", capability.minimum, type.minimum);
  add_range(tree, "maximum", capability.maximum, type.maximum);
  if (!type.words.empty()) tree["words"] = words_of(type.words);
  if (!capability.words.empty()) add_words(tree, capability.words);
  tree["access"] = to_string(capability.access);
  tree["report"] = type.report == model::Report::kEvent ? "event" : "state";
  tree["instance"] = point.details->id.substr(std::min(point.details->id.find('-'), point.details->id.size() - 1) + 1);
  return dump(tree);
}

std::string device_description(const Device& device) {
  Tree lists[3] = {Tree::array(), Tree::array(), Tree::array()};
  Tree capabilities = Tree::array();
  for (const auto& point : device.points) {
    lists[static_cast<std::size_t>(point.id.kind)].push_back(point.details->id);
    const auto type = point.details->id.substr(0, point.details->id.find('-'));
    if (std::find(capabilities.begin(), capabilities.end(), type) == capabilities.end()) capabilities.push_back(type);
  }
  Tree tree;
  tree["name"] = device.name;
  if (!device.area.empty()) tree["area"] = device.area.text();
  tree["model"] = device.model;
  tree["type"] = device.type;
  tree["address"] = device.address;
  tree["network"] = device.network->id;
  tree["capabilities"] = std::move(capabilities);
  tree["sensors"] = std::move(lists[0]);
  tree["actuators"] = std::move(lists[1]);
  tree["properties"] = std::move(lists[2]);
  return dump(tree);
}

void append_reachable(const Network& network, std::string_view before, std::string& list) {
  for (const auto& [id, device] : network.by_id) {
    if (device->status != DeviceStatus::kReachable) continue;
    if (list.size() > 1) list += ',';
    list += '"';
    list += before;
    list += id;  // a key part needs no escapes
    list += '"';
  }
}

std::string reachable_devices(const Network& network) {
  std::string out = "[";
  append_reachable(network, {}, out);
  return out + ']';
}

}  // namespace rubicon::proxy
