#include "transport/mosquitto_properties.h"

#include <mqtt_protocol.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace rubicon::transport {

namespace {

using std::chrono::seconds;

Properties property_of(int id, std::uint32_t value) {
  mosquitto_property* made = nullptr;
  ::mosquitto_property_add_int32(&made, id, value);
  return Properties(made);
}

}  // namespace

MqttConnack read_connack(const mosquitto_property* properties, bool version_5, Duration our_keep_alive) {
  auto keep_alive = static_cast<std::uint16_t>(std::chrono::floor<seconds>(our_keep_alive).count());
  std::uint32_t largest = 0;
  std::uint8_t retains = 1;
  ::mosquitto_property_read_int32(properties, MQTT_PROP_MAXIMUM_PACKET_SIZE, &largest, false);
  ::mosquitto_property_read_byte(properties, MQTT_PROP_RETAIN_AVAILABLE, &retains, false);
  ::mosquitto_property_read_int16(properties, MQTT_PROP_SERVER_KEEP_ALIVE, &keep_alive, false);
  return {version_5 ? MqttVersion::k5 : MqttVersion::k311, largest, retains != 0, seconds(keep_alive), {}};
}

std::size_t read_receive_maximum(const mosquitto_property* properties) {
  std::uint16_t at_once = std::numeric_limits<std::uint16_t>::max();
  ::mosquitto_property_read_int16(properties, MQTT_PROP_RECEIVE_MAXIMUM, &at_once, false);
  return at_once;
}

Properties connect_properties(const MqttOptions& options) {
  return property_of(MQTT_PROP_MAXIMUM_PACKET_SIZE, static_cast<std::uint32_t>(options.largest_packet));
}

Properties publish_properties(const MqttPublication& publication) {
  if (publication.expiry <= Duration::zero()) return nullptr;
  constexpr seconds::rep kLongest = std::numeric_limits<std::uint32_t>::max();
  const auto expiry = std::min(std::chrono::ceil<seconds>(publication.expiry).count(), kLongest);
  return property_of(MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, static_cast<std::uint32_t>(expiry));
}

}  // namespace rubicon::transport
