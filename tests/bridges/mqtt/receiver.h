#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "transport/transports.h"

namespace rubicon::bridges::mqtt {

/// A small consumer that behaves as Home Assistant: it knows nothing but what is announced, asks for the topics that an
/// announcement names, shows an entity as available only if all its topics say so, and commands by its payloads.
class Receiver {
 public:
  explicit Receiver(transport::Transports& transports, std::uint16_t port = 1883) {
    transport::MqttCallbacks calls;
    calls.connected = [this](const transport::MqttConnack&) {
      for (const auto* filter : {"homeassistant/device/+/config", "homeassistant/+/+/+/config"})
        EXPECT_TRUE(line_->subscribe(filter));
      EXPECT_TRUE(line_->publish({"homeassistant/status", "online"}));
    };
    calls.received = [this](const transport::MqttMessage& message) { take(message); };
    calls.failed = [this](const Error& why) { failure = why.text; };
    transport::MqttOptions options;
    options.host = "127.0.0.1";
    options.port = port;
    line_ = transports.open_mqtt(options, std::move(calls)).value();
  }

  bool has(const std::string& unique) const { return entities_.contains(unique); }
  std::size_t entities() const { return entities_.size(); }
  /// `unavailable`, `unknown`, or the last state.
  std::string state(const std::string& unique) const {
    const auto found = entities_.find(unique);
    if (found == entities_.end()) return "(none)";
    for (const auto& one : found->second.at("avty")) {
      if (text_at(one.at("t").get<std::string>()) != "online") return "unavailable";
    }
    const auto text = text_at(found->second.value("stat_t", ""));
    return text.empty() ? "unknown" : text;
  }
  void command(const std::string& unique, const std::string& payload) {
    EXPECT_TRUE(line_->publish({entities_.at(unique).at("cmd_t").get<std::string>(), payload, false, 1}));
  }
  std::string failure;

 private:
  std::string text_at(const std::string& topic) const {
    const auto found = states_.find(topic);
    return found == states_.end() ? std::string() : found->second;
  }
  void take(const transport::MqttMessage& message) {
    if (!message.topic.ends_with("/config")) {
      if (!message.payload.empty() || message.topic.ends_with("/online"))
        states_[std::string(message.topic)] = message.payload;
      return;
    }
    const auto topic = std::string(message.topic);
    std::erase_if(entities_, [&](const auto& one) { return one.second.value("from", "") == topic; });
    if (message.payload.empty()) return;
    const auto whole = nlohmann::json::parse(message.payload);
    if (whole.contains("cmps")) {
      for (const auto& [id, component] : whole["cmps"].items()) add(topic, component, whole);
    } else {
      add(topic, whole, whole);
    }
  }
  void add(const std::string& topic, nlohmann::json entity, const nlohmann::json& whole) {
    if (!entity.contains("avty")) entity["avty"] = whole["avty"];
    entity["from"] = topic;
    for (const auto& one : entity["avty"]) EXPECT_TRUE(line_->subscribe(one["t"].get<std::string>()));
    if (entity.contains("stat_t")) std::ignore = line_->subscribe(entity["stat_t"].get<std::string>());
    const auto unique = entity["uniq_id"].get<std::string>();
    entities_[unique] = std::move(entity);
  }

  std::map<std::string, nlohmann::json> entities_;
  std::map<std::string, std::string> states_;
  std::unique_ptr<transport::MqttLine> line_;
};

}  // namespace rubicon::bridges::mqtt
