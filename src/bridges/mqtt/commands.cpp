#include "bridges/mqtt/commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/home_assistant.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

namespace {

constexpr std::string_view kSet = "/set";

/// The point of this role beside a siren: of the same instance, or the only one.
const PointEntry* part_of(const PointEntry& siren, std::string_view role) {
  for (const auto& row : model::entity_parts()) {
    if (row.platform != "siren" || row.role != role) continue;
    std::vector<const PointEntry*> all;
    for (const auto* point : siren.device->points) {
      if (point->type() != row.type || !point->can_write()) continue;
      if (point->instance() == siren.instance()) return point;
      all.push_back(point);
    }
    if (all.size() == 1) return all.front();
  }
  return nullptr;
}

/// A member of their object as a command for its point. Theirs is a loudness from 0 to 1, ours is in its own range.
std::string command_for(const PointEntry& part, const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (part.type() != "volume" || !value.is_number()) return model::dump(value);
  const auto least = part.about->minimum.value_or(0), most = part.about->maximum.value_or(100);
  return fmt::format("{:g}", least + (most - least) * value.get<double>());
}

/// A response topic must not be a command.
bool can_answer_at(const std::string& base, std::string_view topic) {
  return !topic.empty() && topic.find_first_of("+#") == topic.npos && !topic.starts_with('$') &&
         !topic.starts_with(base + "/");
}

}  // namespace

Result<PointEntry*> Commands::check(const transport::MqttMessage& message, std::string_view topic) const {
  auto* point = house_.find_by_topic(topic);
  if (point == nullptr) return fail(ErrorCode::kNotFound, fmt::format("{}: no such point", topic));
  if (auto allowed = desk_.check(*point, message.payload, message.sender); !allowed) return fail(allowed.error());
  return point;
}

void Commands::take(const transport::MqttMessage& message) {
  if (!message.topic.ends_with(kSet) || message.retained) return;
  const auto topic = message.topic.substr(0, message.topic.size() - kSet.size());
  Way way{std::string(topic), std::string(message.response_topic), std::string(message.correlation)};
  if (!can_answer_at(options_.base, way.response)) way.response.clear();
  ++taken_;
  const auto* siren = house_.find_by_topic(topic);
  auto one = message;
  std::string state;
  if (siren && siren->type() == "siren" && message.payload.starts_with('{') &&
      message.payload.size() <= CommandDesk::kMaxText && !base::is_nested_deeper(message.payload, 1)) {
    const auto object = model::object_of(message.payload);
    if (auto set = send_parts(*siren, message, object); !set) return refuse(way, set.error());
    state = model::text_of(object, "state");
    one.payload = state;
  }
  const auto point = check(one, topic);
  if (!point) return refuse(way, point.error());
  send(**point, one, std::move(way));
}

/// What Home Assistant sends to a siren with such parts: `{"state":"on","tone":"fire","duration":10}`. They are points
/// of their own.
Result<void> Commands::send_parts(const PointEntry& siren, const transport::MqttMessage& message,
                                  const nlohmann::json& object) {
  for (const auto* role : {"tone", "duration", "volume_level"}) {
    const auto value = object.find(role);
    const auto* part = value == object.end() ? nullptr : part_of(siren, role);
    if (part == nullptr) continue;
    const auto text = command_for(*part, *value);
    auto one = message;
    one.payload = text;
    const auto point = check(one, part->topic());
    if (!point) return fail(point.error());
    send(**point, one, {part->topic(), {}, {}});
  }
  return {};
}

void Commands::refuse(const Way& way, const Error& why) {
  log_.info(way.topic, fmt::format("a command was refused: {}", why.text));
  answer(way, {"refused", why.text});
}

void Commands::send(const PointEntry& point, const transport::MqttMessage& message, Way way) {
  const auto lives = message.expiry > Duration(0) ? std::min(message.expiry, kMaxToLive) : CommandDesk::kTimeToLive;
  desk_.send(point, message.payload, message.sender, lives,
             [this, way = std::move(way)](const client::Outcome& outcome) { answer(way, outcome); });
}

void Commands::answer(const Way& way, const client::Outcome& outcome) {
  const nlohmann::ordered_json json{{"state", outcome.state}, {"reason", outcome.reason}, {"request", outcome.request}};
  transport::MqttPublication message;
  message.topic = way.response.empty() ? way.topic + "/outcome" : way.response;
  message.payload = model::dump(json);
  message.qos = 1;
  message.correlation = way.correlation;
  if (transport::is_mqtt_topic(message.topic)) callbacks_.publish(std::move(message));
  if (outcome.good()) return;
  ++refused_;
  callbacks_.correct(way.topic);
}

}  // namespace rubicon::bridges::mqtt
