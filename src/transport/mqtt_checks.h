#pragma once

#include <string>
#include <string_view>

#include "transport/mqtt.h"

namespace rubicon::transport {

/// The broker in texts of errors: `MQTT broker.lan:1883`.
std::string mqtt_name(const MqttOptions& options);

/// kInvalid with the reason, for what no broker can accept.
Result<void> check_options(const MqttOptions& options);
Result<void> check_filter(std::string_view filter, std::uint8_t qos, const std::string& line);
/// Also kOutOfRange beyond the broker's longest packet, in bytes.
Result<void> check_publication(const MqttPublication& publication, std::size_t largest, const std::string& line);

/// Length in bytes of a PUBLISH packet with this topic and payload (MQTT 5, section 3.3), within a few bytes.
std::size_t packet_size(std::string_view topic, std::string_view payload);

/// What a reason code of CONNACK or DISCONNECT means to the user of a line (MQTT 5, section 2.4).
Error mqtt_error(int reason, const std::string& line);
/// What a reason code of PUBACK (0x80 or above) means for a publication to this topic (MQTT 5, section 3.4.2.1).
Error publication_error(int reason, const std::string& line, std::string_view topic);
/// The reason of version 5 for a return code of a CONNACK of 3.1.1 (section 3.2.2.3 there).
int reason_of_return_code(int code);

}  // namespace rubicon::transport
