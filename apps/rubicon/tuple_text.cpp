#include "apps/rubicon/tuple_text.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/rubicon/table.h"
#include "base/bytes.h"
#include "base/local_time.h"
#include "tuples/tuple_json.h"

namespace rubicon::cli {

namespace {

/// Of `<prefix>.<network>.<device>.<kind>.<id>.value`.
constexpr std::size_t kPointParts = 6;

bool is_kind(std::string_view part) {
  return part == "sensor" || part == "actuator" || part == "property";
}

}  // namespace

std::string dump(const Line& line) {
  return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

nlohmann::json object_of(std::string_view text) {
  auto tree = nlohmann::json::parse(text, nullptr, false);
  return tree.is_object() ? tree : nlohmann::json::object();
}

std::string text_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double number_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

bool flag_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

std::uint64_t count_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

Line tuple_json(const client::Tuple& tuple) {
  Line line;
  line["owner"] = number(tuple.owner);
  line["key"] = tuple.key;
  if (base::is_utf8(tuple.value)) {
    line["value"] = tuple.value;
  } else {
    line["value_hex"] = base::to_hex(base::as_bytes(tuple.value));
  }
  line["mimetype"] = tuple.media_type;
  line["seq"] = tuple.sequence;
  line["write"] = base::to_seconds(tuple.write_time);
  line["user"] = base::to_seconds(tuple.user_time);
  line["time"] = base::iso_text(tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time);
  line["creator"] = number(tuple.creator);
  line["expire"] = base::to_seconds(tuple.expire_time);
  if (!tuple.owner_present) line["present"] = false;
  return line;
}

std::string name_of(OwnerId owner, std::string_view key) {
  return fmt::format("{}:{}", number(owner), key);
}

WallTime wall_time(double seconds) {
  constexpr double kLatest = 1e11;
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * 1e6)));
}

Line point_json(const client::Point& point) {
  auto line = tuple_json(point.tuple);
  const auto& status = point.status;
  if (status.quality.empty()) return line;
  line["quality"] = status.quality;
  line["reason"] = status.reason;
  line["heard"] = base::to_seconds(status.heard);
  line["changed"] = base::to_seconds(status.changed);
  line["line"] = point.line.line;
  line["line_reason"] = point.line.reason;
  return line;
}

std::string quality_text(const client::Point& point) {
  const auto& status = point.status;
  return status.reason.empty() ? status.quality : fmt::format("{}: {}", status.quality, status.reason);
}

std::string line_text(const LineStatus& line) {
  return line.reason.empty() ? line.line : fmt::format("{}: {}", line.line, line.reason);
}

std::string next_attempt_text(const LineStatus& line, WallTime now) {
  if (line.works() || line.next_attempt == WallTime{}) return {};
  if (line.next_attempt <= now) return "next attempt now";
  return fmt::format("next attempt in {}", age_text(now, line.next_attempt));
}

bool is_value_of_point(std::string_view key) {
  const auto parts = model::key_parts(key);
  return parts.size() == kPointParts && is_kind(parts[3]) && parts[5] == "value";
}

std::optional<Pattern> points_of(const Pattern& pattern) {
  const auto parts = model::key_parts(pattern.key);
  if (parts.size() != kPointParts || parts[5] != "value") return std::nullopt;
  return Pattern{pattern.owner, without_last_part(pattern.key)};
}

std::string without_last_part(std::string_view key) {
  const auto dot = key.rfind('.');
  return std::string(key.substr(0, dot == key.npos ? 0 : dot));
}

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

}  // namespace rubicon::cli
