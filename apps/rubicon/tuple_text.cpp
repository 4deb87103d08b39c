#include "apps/rubicon/tuple_text.h"

#include <fmt/format.h>

#include "apps/rubicon/table.h"
#include "base/bytes.h"
#include "base/local_time.h"
#include "client/json_forms.h"
#include "model/point_keys.h"

namespace rubicon::cli {

Line tuple_json(const client::Tuple& tuple) {
  return client::whole_tuple_json(tuple);
}

std::string name_of(OwnerId owner, std::string_view key) {
  return fmt::format("{}:{}", number(owner), key);
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
  if (!point.unit.empty()) line["unit"] = point.unit;
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
  return model::last_part(key) == "value" && model::point_of(key).has_value();
}

std::optional<Pattern> points_of(const Pattern& pattern) {
  constexpr std::size_t kParts = 6;
  const auto parts = model::key_parts(pattern.key);
  if (parts.size() != kParts || parts.back() != "value") return std::nullopt;
  return Pattern{pattern.owner, std::string(model::parent_key(pattern.key))};
}

}  // namespace rubicon::cli
