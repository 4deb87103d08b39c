#include "networks/zigbee/zigbee_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/host_port.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

constexpr std::uint16_t kMqttPort = 1883;
constexpr std::size_t kMaxBase = 256;

/// A topic without wildcards and empty parts (MQTT 5, section 4.7).
bool is_topic(std::string_view text) {
  const bool characters = std::none_of(
      text.begin(), text.end(), [](char c) { return c == '+' || c == '#' || static_cast<unsigned char>(c) < 0x20; });
  return characters && !text.empty() && text.size() <= kMaxBase && text.front() != '/' && text.back() != '/';
}

}  // namespace

ZigbeeOptions read_zigbee_options(const network::NetworkConfig& config) {
  ConfigReader& options = config.options;
  ZigbeeOptions out;
  const auto broker = options.required_text("broker");
  if (const auto at = base::parse_host_port(broker, kMqttPort)) {
    out.broker.host = at->host;
    out.broker.port = at->port;
  } else if (!broker.empty()) {
    options.error("broker", fmt::format("is {}, expected HOST or HOST:PORT", model::quoted(broker)));
  }
  out.base = options.text("base", out.base);
  if (!is_topic(out.base))
    options.error(
        "base",
        fmt::format("is {}, expected mqtt.base_topic of Zigbee2MQTT: no +, #, control character, nor / at an end",
                    model::quoted(out.base)));
  out.polls_per_second = static_cast<unsigned>(options.integer("polls-per-second", out.polls_per_second, 1, 100));
  out.most_devices = config.most_devices;
  return out;
}

}  // namespace rubicon::networks::zigbee
