#include "networks/zigbee/zigbee_options.h"

#include <fmt/format.h>

#include <tuple>

#include "networks/zigbee/bridge/topics.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

auto tls_of(const transport::MqttBrokerOptions& broker) {
  const auto tls = broker.line.tls.value_or(transport::MqttTls{});
  return std::tuple(broker.line.tls.has_value(), tls.ca_file, tls.certificate_file, tls.key_file, tls.server_name);
}

auto line_of(const ZigbeeOptions& options) {
  const auto& broker = options.broker;
  const auto& line = broker.line;
  return std::tie(options.base, line.host, line.port, line.user, line.version, line.largest_packet,
                  broker.password_file, broker.password_variable);
}

}  // namespace

ZigbeeOptions read_zigbee_options(const network::NetworkConfig& config) {
  ConfigReader& options = config.options;
  ZigbeeOptions out;
  out.broker = transport::read_mqtt_broker(options, config.directory);
  out.base = options.text("base", out.base);
  if (const auto checked = bridge::Topics::check_base(out.base); !checked)
    options.error("base", fmt::format("is {}, expected mqtt.base_topic of Zigbee2MQTT: {}", model::quoted(out.base),
                                      checked.error().text));
  out.polls_per_second = static_cast<unsigned>(options.integer("polls-per-second", out.polls_per_second, 1, 100));
  out.most_devices = config.most_devices;
  return out;
}

bool same_line(const ZigbeeOptions& one, const ZigbeeOptions& other) {
  return line_of(one) == line_of(other) && tls_of(one.broker) == tls_of(other.broker) &&
         one.most_devices == other.most_devices;
}

}  // namespace rubicon::networks::zigbee
