#include "bridges/mqtt/leftovers.h"

#include <algorithm>

namespace rubicon::bridges::mqtt {

namespace {

constexpr std::string_view kPresence = "/online";

std::string_view above(std::string_view topic) {
  return topic.substr(0, std::min(topic.rfind('/'), topic.size()));
}

}  // namespace

/// Devices, points, whether a point is there. They do not overlap with each other or with those of commands: a broker
/// may send a message once for each filter.
std::vector<std::string> Leftovers::filters() const {
  const auto& base = options_.base;
  std::vector<std::string> all{base + "/+/+/+/online", base + "/+/+/+/+/+", base + "/+/+/+/+/+/online"};
  const auto& discovery = options_.discovery_base;
  if (options_.discovery == Discovery::kNone) return all;
  all.push_back(discovery + "/device/+/config");
  all.push_back(discovery + "/+/+/+/config");
  return all;
}

void Leftovers::take(const transport::MqttMessage& message) {
  const bool announced = announcer_.is_of_rubicon(message.topic);
  const bool foreign = announced && !message.payload.empty() && !announcer_.is_ours(message.payload);
  disputed_ |= foreign && !message.retained;  // what a run before left is written over
  if (!message.retained || message.payload.empty() || topics_.size() >= kMaxTopics) return;
  const bool ours = announced ? announcer_.is_ours(message.payload) : message.topic.starts_with(options_.base + "/");
  if (ours) topics_.emplace(message.topic, announced);
}

bool Leftovers::is_other_form(const transport::MqttMessage& message) const {
  if (!message.retained || !announcer_.is_of_rubicon(message.topic)) return false;
  const bool whole = message.topic.starts_with(options_.discovery_base + "/device/");
  return whole != (options_.discovery == Discovery::kDevices) && announcer_.is_ours(message.payload);
}

bool Leftovers::is_gone(const std::string& topic) const {
  bool there = false;
  house_.each_island([&](IslandEntry& island) { there |= island.present && topic.starts_with(island.topic + "/"); });
  if (!there) return false;
  const auto point = topic.ends_with(kPresence) ? above(topic) : std::string_view(topic);
  return house_.find_by_topic(point) == nullptr && house_.find_device(point) == nullptr;
}

std::set<std::string> Leftovers::gone(const std::set<std::string>& kept) {
  std::set<std::string> all;
  for (const auto& [topic, announced] : std::exchange(topics_, {})) {
    if (announced ? !kept.contains(topic) : is_gone(topic)) all.insert(topic);
  }
  return all;
}

}  // namespace rubicon::bridges::mqtt
