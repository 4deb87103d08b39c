#include "state/state_export.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_text.h"
#include "model/message.h"
#include "model/message_fields.h"
#include "model/type_names.h"

namespace rubicon::state {

namespace {

using model::FieldReader;
using nlohmann::json;

constexpr std::uint64_t kFormVersion = 1;
constexpr std::size_t kMaxDepth = 16;

/// Replaces each text that is not UTF-8 by {"hex": digits}.
void encode_bytes(json& item) {
  if (item.is_string() && !base::is_utf8(item.get_ref<const std::string&>())) {
    item = json{{"hex", base::to_hex(base::as_bytes(item.get_ref<const std::string&>()))}};
  } else if (item.is_structured()) {
    for (auto& part : item) encode_bytes(part);
  }
}

/// The reverse. False: the digits are not hexadecimal, or the item is nested too deep.
bool decode_bytes(json& item, std::size_t depth = 0) {
  if (depth > kMaxDepth) return false;
  if (item.is_object() && item.size() == 1 && item.contains("hex")) {
    const auto& digits = item["hex"];
    if (!digits.is_string()) return false;
    const auto bytes = base::from_hex(digits.get_ref<const std::string&>());
    if (!bytes) return false;
    item = std::string(base::as_text(*bytes));
    return true;
  }
  if (!item.is_structured()) return true;
  for (auto& part : item) {
    if (!decode_bytes(part, depth + 1)) return false;
  }
  return true;
}

std::int64_t microseconds(WallTime time) {
  return time.time_since_epoch().count();
}

WallTime time_from_json(FieldReader& in, const char* key) {
  return WallTime(std::chrono::microseconds(in.signed_number(key)));
}

json point_to_json(const model::PointId& point) {
  return {
      {"kind", to_string(point.kind)}, {"type", static_cast<std::uint16_t>(point.type)}, {"instance", point.instance}};
}

model::PointId point_from_json(FieldReader& in) {
  model::PointId point;
  const auto kind = in.text("kind");
  for (const auto candidate : {Kind::kSensor, Kind::kActuator, Kind::kProperty}) {
    if (to_string(candidate) == kind) point.kind = candidate;
  }
  if (to_string(point.kind) != kind) in.wrong("kind", "sensor, actuator or property");
  if (!in.has("type")) in.wrong("type", "a type number");
  point.type = TypeId(static_cast<std::uint16_t>(in.number("type", UINT16_MAX)));
  point.instance = in.text("instance", 255);
  return model::current_point(std::move(point));
}

json value_to_json(const StoredValue& value) {
  auto out = point_to_json(value.point);
  out["value"] = model::value_to_json(value.value);
  out["heard-us"] = microseconds(value.heard);
  out["changed-us"] = microseconds(value.changed);
  out["user-us"] = microseconds(value.user_time);
  out["set-by-user"] = value.set_by_user;
  return out;
}

StoredValue value_from_json(FieldReader& in) {
  StoredValue value;
  value.point = point_from_json(in);
  value.value = in.value("value");
  value.heard = time_from_json(in, "heard-us");
  value.changed = time_from_json(in, "changed-us");
  value.user_time = time_from_json(in, "user-us");
  value.set_by_user = in.boolean("set-by-user");
  return value;
}

/// The form that a join has in messages.
json join_to_json(const model::Join& join) {
  Message message;
  message.body = join;
  return json::from_cbor(model::to_cbor(message))["body"];
}

Result<model::Join> join_from_json(const json& join) {
  const json form{{"v", 1}, {"kind", "join"}, {"body", join}};
  auto message = model::from_cbor(json::to_cbor(form));
  if (!message) return fail(message.error());
  return std::move(std::get<model::Join>(message->body));
}

Decision decision_from_json(FieldReader& in) {
  const auto word = in.text("decision");
  for (const auto decision : {Decision::kNone, Decision::kApproved, Decision::kIgnored}) {
    if (to_string(decision) == word) return decision;
  }
  in.wrong("decision", "none, approved or ignored");
  return Decision::kNone;
}

Result<KnownDevice> device_from_json(const json& line) {
  Error error{ErrorCode::kInvalid, {}};
  FieldReader in(line, "", error);
  KnownDevice device;
  for (const auto* key : {"network", "address", "join"}) {
    if (!in.has(key)) in.wrong(key, "a value");
  }
  device.network = in.text("network", 255);
  device.address = in.text("address", 255);
  device.id = in.text("id", 255);
  device.given_name = in.text("given-name", kMaxGiven);
  device.area = in.text("area", kMaxGiven);
  device.decision = decision_from_json(in);
  device.first_seen = time_from_json(in, "first-seen-us");
  device.last_heard = time_from_json(in, "last-heard-us");
  in.each("point-ids", [&device](FieldReader& item) {
    auto point = point_from_json(item);
    device.point_ids.emplace_back(std::move(point), model::current_id(item.text("id", 255)));
  });
  in.each("values", [&device](FieldReader& item) { device.values.push_back(value_from_json(item)); });
  if (!in.ok()) return fail(std::move(error));
  auto join = join_from_json(line["join"]);
  if (!join) return fail(join.error());
  device.join = std::move(*join);
  return device;
}

/// Removes what the message reader puts before its errors: `message: `, and a dot before the path of a list.
std::string_view without_prefix(std::string_view text) {
  for (const std::string_view prefix : {"message: ", "."}) {
    if (text.starts_with(prefix)) text.remove_prefix(prefix.size());
  }
  return text;
}

}  // namespace

std::string export_head(IslandId island) {
  return fmt::format(R"({{"rubicon-state":{},"island":{}}})", kFormVersion, number(island));
}

std::string export_line(const KnownDevice& device) {
  json line{{"network", device.network},
            {"address", device.address},
            {"id", device.id},
            {"decision", to_string(device.decision)},
            {"first-seen-us", microseconds(device.first_seen)},
            {"last-heard-us", microseconds(device.last_heard)},
            {"join", join_to_json(device.join)},
            {"point-ids", json::array()},
            {"values", json::array()}};
  if (!device.given_name.empty()) line["given-name"] = device.given_name;
  if (!device.area.empty()) line["area"] = device.area;
  for (const auto& [point, id] : device.point_ids) {
    auto& item = line["point-ids"].emplace_back(point_to_json(point));
    item["id"] = id;
  }
  for (const auto& value : device.values) line["values"].push_back(value_to_json(value));
  encode_bytes(line);
  return model::dump(line);
}

std::string export_end(std::uint64_t devices) {
  return fmt::format(R"({{"end":true,"devices":{}}})", devices);
}

Error ExportReader::wrong(std::string_view what) const {
  return {ErrorCode::kInvalid, fmt::format("line {}: {}", lines_, what)};
}

Result<void> ExportReader::head(std::string_view text) {
  constexpr std::string_view kExpected = R"(expected {"rubicon-state":1,"island":NUMBER}, the first line of an export)";
  const auto line = model::parse_json(text);
  Error error{ErrorCode::kInvalid, {}};
  FieldReader in(line, "", error);
  if (!in.ok() || !in.has("rubicon-state")) return fail(wrong(kExpected));
  const auto version = in.number("rubicon-state", UINT32_MAX);
  const IslandId island{static_cast<std::uint32_t>(in.number("island", UINT32_MAX))};
  if (!in.ok() || !model::is_island(island)) return fail(wrong(kExpected));
  if (version != kFormVersion) {
    return fail(wrong(fmt::format("an export of version {}, expected {}", version, kFormVersion)));
  }
  island_ = island;
  return {};
}

Result<std::optional<KnownDevice>> ExportReader::line(std::string_view text) {
  ++lines_;
  if (text.size() > kMaxExportLine) {
    return fail(wrong(fmt::format("has {} bytes, expected at most {}", text.size(), kMaxExportLine)));
  }
  if (base::is_nested_deeper(text, kMaxDepth))
    return fail(wrong(fmt::format("nested deeper, expected at most {} levels", kMaxDepth)));
  if (!island_) {
    if (auto done = head(text); !done) return fail(done.error());
    return std::optional<KnownDevice>();
  }
  if (ended_) return fail(wrong("follows the last line of the export"));
  auto line = model::parse_json(text);
  if (!line.is_object()) return fail(wrong("expected a JSON object"));
  if (line.contains("end")) {
    ended_ = true;
    if (line.value("devices", json()) == json(devices_)) return std::optional<KnownDevice>();
    return fail(
        wrong(fmt::format("the export was written with another number of devices than the {} above", devices_)));
  }
  ++devices_;
  if (!decode_bytes(line)) return fail(wrong(R"(expected hexadecimal digits in {"hex": ...})"));
  auto device = device_from_json(line);
  if (!device) return fail(wrong(without_prefix(device.error().text)));
  return std::optional(std::move(*device));
}

Result<void> ExportReader::end() const {
  if (ended_) return {};
  return fail(ErrorCode::kInvalid, fmt::format("after line {}: the export is incomplete, expected more lines", lines_));
}

}  // namespace rubicon::state
