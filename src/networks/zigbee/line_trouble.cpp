#include "networks/zigbee/line_trouble.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

std::string first_of(const std::set<std::string>& topics) {
  return fmt::format("{}{}", model::quoted(*topics.begin()),
                     topics.size() == 1 ? "" : fmt::format(" and {} more", topics.size() - 1));
}

std::string who(const LineFacts& facts) {
  return facts.user.empty() ? "clients without a user" : "the user " + model::quoted(facts.user);
}

std::string missing_list(const LineFacts& facts) {
  if (facts.too_long)
    return fmt::format(
        "the list of devices was not read: it has {} bytes, more than largest-packet ({}); raise largest-packet",
        *facts.too_long, facts.largest_packet);
  if (!facts.retains)
    return "the list of devices was not received: the broker does not keep it for clients that come later; set "
           "mqtt.force_disable_retain of Zigbee2MQTT to false";
  if (!facts.others_came)
    return "the broker has no list of devices: it was restarted without its retained messages; restart Zigbee2MQTT";
  return fmt::format(
      "the list of devices was not received, though other messages of Zigbee2MQTT were: the broker limits the length "
      "of messages (mosquitto: message_size_limit, max_packet_size), or the list has more than largest-packet ({} "
      "bytes); raise that limit and restart Zigbee2MQTT",
      facts.largest_packet);
}

}  // namespace

std::string line_trouble(const LineFacts& facts) {
  if (!facts.forbidden.empty())
    return fmt::format("the broker forbids to subscribe to {}: let {} read {} in its access rules",
                       first_of(facts.forbidden), who(facts), model::quoted(facts.base + "/#"));
  if (facts.list_missing) return missing_list(facts);
  if (facts.silent_devices > 0)
    return fmt::format(
        "no state of any of {} devices: the access rules of the broker hide them (let {} read {}), or no device is in "
        "reach",
        facts.silent_devices, who(facts), model::quoted(facts.base + "/#"));
  if (!facts.not_taken.empty())
    return fmt::format("the broker does not take messages to {}: let {} write there in its access rules",
                       first_of(facts.not_taken), who(facts));
  return {};
}

}  // namespace rubicon::networks::zigbee
