#include "state/state_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/printable.h"
#include "model/former_types.h"
#include "model/message_cbor.h"
#include "model/message_fields.h"

namespace rubicon::state {

namespace {

using model::FieldReader;
using nlohmann::json;
using state::KnownDevice;
using state::StoredValue;

constexpr std::uint64_t kFormVersion = 1;
constexpr int kMaxDepth = 16;

/// Text that is not UTF-8 stands as {"hex": digits} wherever it is.
void armour(json& item) {
  if (item.is_string() && !base::is_utf8(item.get_ref<const std::string&>())) {
    item = json{{"hex", base::to_hex(base::as_bytes(item.get_ref<const std::string&>()))}};
  } else if (item.is_structured()) {
    for (auto& part : item) armour(part);
  }
}

/// False: hexadecimal digits were expected, or it is nested too deep.
bool disarm(json& item, int depth = 0) {
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
    if (!disarm(part, depth + 1)) return false;
  }
  return true;
}

std::int64_t us(WallTime time) {
  return time.time_since_epoch().count();
}

WallTime time_in(FieldReader& in, const char* key) {
  return WallTime(std::chrono::microseconds(in.signed_number(key)));
}

json point_out(const model::PointId& point) {
  return {
      {"kind", to_string(point.kind)}, {"type", static_cast<std::uint16_t>(point.type)}, {"instance", point.instance}};
}

model::PointId point_in(FieldReader& in) {
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

json value_out(const StoredValue& value) {
  auto out = point_out(value.point);
  out["value"] = model::value_to_json(value.value);
  out["heard-us"] = us(value.heard);
  out["changed-us"] = us(value.changed);
  out["user-us"] = us(value.user_time);
  out["set-by-user"] = value.set_by_user;
  return out;
}

StoredValue value_in(FieldReader& in) {
  StoredValue value;
  value.point = point_in(in);
  value.value = in.value("value");
  value.heard = time_in(in, "heard-us");
  value.changed = time_in(in, "changed-us");
  value.user_time = time_in(in, "user-us");
  value.set_by_user = in.boolean("set-by-user");
  return value;
}

/// A join is written as messages write it.
json join_out(const model::Join& join) {
  Message message;
  message.body = join;
  return json::from_cbor(model::to_cbor(message))["body"];
}

Result<model::Join> join_in(const json& join) {
  const json form{{"v", 1}, {"kind", "join"}, {"body", join}};
  auto message = model::from_cbor(json::to_cbor(form));
  if (!message) return fail(message.error());
  return std::move(std::get<model::Join>(message->body));
}

state::Decision decision_in(FieldReader& in) {
  const auto word = in.text("decision");
  for (const auto decision : {state::Decision::kNone, state::Decision::kApproved, state::Decision::kIgnored}) {
    if (to_string(decision) == word) return decision;
  }
  in.wrong("decision", "none, approved or ignored");
  return state::Decision::kNone;
}

Result<KnownDevice> device_in(const json& line) {
  Error error{ErrorCode::kInvalid, {}};
  FieldReader in(line, "", error);
  KnownDevice device;
  for (const auto* key : {"network", "address", "join"}) {
    if (!in.has(key)) in.wrong(key, "to be there");
  }
  device.network = in.text("network", 255);
  device.address = in.text("address", 255);
  device.id = in.text("id", 255);
  device.given_name = in.text("given-name", state::kMaxGiven);
  device.area = in.text("area", state::kMaxGiven);
  device.decision = decision_in(in);
  device.first_seen = time_in(in, "first-seen-us");
  device.last_heard = time_in(in, "last-heard-us");
  in.each("point-ids", [&device](FieldReader& item) {
    auto point = point_in(item);
    device.point_ids.emplace_back(std::move(point), model::current_id(item.text("id", 255)));
  });
  in.each("values", [&device](FieldReader& item) { device.values.push_back(value_in(item)); });
  if (!in.ok()) return fail(std::move(error));
  auto join = join_in(line["join"]);
  if (!join) return fail(join.error());
  device.join = std::move(*join);
  return device;
}

/// Errors of the message reader call everything a message, and begin the path of a list with a dot.
std::string_view without_prefix(std::string_view text) {
  for (const std::string_view prefix : {"message: ", "."}) {
    if (text.starts_with(prefix)) text.remove_prefix(prefix.size());
  }
  return text;
}

/// JSON without building it, so that a hostile line cannot nest without bound.
bool shallow(std::string_view text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxDepth) return false;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return true;
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
            {"first-seen-us", us(device.first_seen)},
            {"last-heard-us", us(device.last_heard)},
            {"join", join_out(device.join)},
            {"point-ids", json::array()},
            {"values", json::array()}};
  if (!device.given_name.empty()) line["given-name"] = device.given_name;
  if (!device.area.empty()) line["area"] = device.area;
  for (const auto& [point, id] : device.point_ids) {
    auto& item = line["point-ids"].emplace_back(point_out(point));
    item["id"] = id;
  }
  for (const auto& value : device.values) line["values"].push_back(value_out(value));
  armour(line);
  return line.dump();
}

std::string export_end(std::uint64_t devices) {
  return fmt::format(R"({{"end":true,"devices":{}}})", devices);
}

Error ExportReader::wrong(std::string_view what) const {
  return {ErrorCode::kInvalid, fmt::format("line {}: {}", lines_, what)};
}

Result<void> ExportReader::head(std::string_view text) {
  constexpr std::string_view kExpected = R"(expected {"rubicon-state":1,"island":NUMBER}, the first line of an export)";
  const auto line = json::parse(text, nullptr, false);
  Error error{ErrorCode::kInvalid, {}};
  FieldReader in(line, "", error);
  if (!in.ok() || !in.has("rubicon-state")) return fail(wrong(kExpected));
  const auto version = in.number("rubicon-state", UINT32_MAX);
  const IslandId island{static_cast<std::uint32_t>(in.number("island", UINT32_MAX))};
  if (!in.ok() || !model::is_island(island)) return fail(wrong(kExpected));
  if (version != kFormVersion) {
    return fail(wrong(fmt::format("version {} of the form, expected {}", version, kFormVersion)));
  }
  island_ = island;
  return {};
}

Result<std::optional<KnownDevice>> ExportReader::line(std::string_view text) {
  ++lines_;
  if (text.size() > kMaxExportLine) {
    return fail(wrong(fmt::format("{} bytes, at most {} are read", text.size(), kMaxExportLine)));
  }
  if (!shallow(text)) return fail(wrong(fmt::format("nested deeper than {} levels", kMaxDepth)));
  if (!island_) {
    if (auto done = head(text); !done) return fail(done.error());
    return std::optional<KnownDevice>();
  }
  if (ended_) return fail(wrong("something after the end of the export"));
  auto line = json::parse(text, nullptr, false);
  if (!line.is_object()) return fail(wrong("expected a JSON object"));
  if (line.contains("end")) {
    ended_ = true;
    if (line.value("devices", json()) == json(devices_)) return std::optional<KnownDevice>();
    return fail(wrong(fmt::format("the export had another number of devices than the {} before this line", devices_)));
  }
  ++devices_;
  if (!disarm(line)) return fail(wrong(R"(expected hexadecimal digits in {"hex": ...})"));
  auto device = device_in(line);
  if (!device) return fail(wrong(without_prefix(device.error().text)));
  return std::optional(std::move(*device));
}

Result<void> ExportReader::end() const {
  if (ended_) return {};
  return fail(ErrorCode::kInvalid, fmt::format("after line {}: the export is cut off, expected more lines", lines_));
}

}  // namespace rubicon::state
