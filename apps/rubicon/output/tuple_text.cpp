#include "apps/rubicon/output/tuple_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/rubicon/output/table.h"
#include "base/bytes.h"
#include "base/clocks.h"
#include "base/text.h"
#include "client/json_forms.h"
#include "model/point_keys.h"
#include "rubicon/unit.hpp"

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

namespace {

std::string bound_text(double bound) {
  return std::isfinite(bound) ? fmt::format("{}", bound) : std::string();
}

std::string between(const std::string& low, const std::string& high) {
  return low.empty() && high.empty() ? std::string() : low + ".." + high;
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

/// `7`, `0x0400`.
bool is_number_of(const Type& type, std::string_view word) {
  const bool hex = word.starts_with("0x");
  const auto digits = hex ? word.substr(2) : word;
  const auto number = hex ? base::parse_hex_number<std::uint16_t>(digits) : base::parse_number<std::uint16_t>(digits);
  return number && TypeId(*number) == type.id;
}

}  // namespace

std::string range_text(const Type& type) {
  if (!type.words.empty()) {
    std::string words(type.words);
    std::replace(words.begin(), words.end(), ',', '|');
    return words;
  }
  if (type.data == model::DataType::kBoolean) return "off|on";
  return between(bound_text(type.minimum), bound_text(type.maximum));
}

std::string range_text(const model::PointDescription& description) {
  std::string words;
  for (const auto& word : description.words) words += (words.empty() ? "" : "|") + word.text;
  if (!words.empty()) return words;
  const auto bound = [](const std::optional<double>& number) { return number ? bound_text(*number) : std::string(); };
  return between(bound(description.minimum), bound(description.maximum));
}

bool found_by(const Type& type, std::string_view word) {
  const auto wanted = lower(word);
  for (const auto text : {type.name, type.quantity, type.unit}) {
    if (lower(text).find(wanted) != std::string::npos) return true;
  }
  return lower(model::unit_text(type.unit)) == wanted || is_number_of(type, word);
}

}  // namespace rubicon::cli
