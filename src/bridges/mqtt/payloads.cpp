#include "bridges/mqtt/payloads.h"

#include <fmt/format.h>

#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::bridges::mqtt {

namespace {

/// `localhost` and its addresses are one broker.
std::string place_of_broker(std::string host, std::uint64_t port) {
  if (host == "localhost" || host == "::1") host = "127.0.0.1";
  return fmt::format("{}:{}", host, port);
}

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

std::string attributes_of(const PointEntry& point, std::string_view status) {
  const auto said = model::point_status_from_json(status);
  nlohmann::ordered_json json{{"quality", said.quality}, {"reason", said.reason}};
  json["heard"] = model::seconds_json(said.heard);
  json["changed"] = model::seconds_json(said.changed);
  if (point.about && point.about->unit != "1") json["unit"] = point.about->unit;
  if (const auto command = model::command_status_from_json(status))
    json["command"] = {{"state", command->state}, {"reason", command->reason}, {"value", command->value}};
  return model::dump(json);
}

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

bool is_broker(const Options& options, std::string_view property) {
  const auto json = model::object_of(property);
  const auto theirs = place_of_broker(model::text_of(json, "host"), model::count_of(json, "port"));
  return theirs == place_of_broker(options.broker.line.host, options.broker.line.port);
}

}  // namespace rubicon::bridges::mqtt
