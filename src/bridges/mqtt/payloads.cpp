#include "bridges/mqtt/payloads.h"

#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::bridges::mqtt {

namespace {

/// Numbers as numbers, booleans of any words as 1 and 0: databases can compute with them.
nlohmann::ordered_json value_json(const PointEntry& point) {
  if (point.value.empty() || (!point.good() && !point.is_event())) return nullptr;
  const auto kind = point.about ? std::string_view(point.about->data_type) : std::string_view();
  if (kind == "real" || kind == "integer") {
    if (const auto parsed = base::parse_number<double>(point.value)) return *parsed;
  }
  if (kind != "boolean") return point.value;
  const auto& words = point.about->words;
  return point.value == (words.size() < 2 ? "on" : words[1].text) ? 1 : 0;
}

}  // namespace

std::string payload_of(const PointEntry& point, const Options& options) {
  if (!options.json) return point.value;
  nlohmann::ordered_json json{{"value", value_json(point)}};
  if (point.about && point.about->unit != "1") json["unit"] = point.about->unit;
  json["quality"] = to_string(point.quality);
  json["time"] = model::seconds_json(point.time);
  return model::dump(json);
}

bool is_online(const PointEntry& point) {
  return point.good() || point.quality == model::Quality::kUnknown;
}

}  // namespace rubicon::bridges::mqtt
