#pragma once

#include <string_view>

namespace rubicon::transport {

/// A topic of a message (MQTT 5, section 4.7): 1 to 65535 bytes of UTF-8, without wildcards and zero bytes.
bool is_mqtt_topic(std::string_view topic);
/// What a subscription may ask for: as above, with `+` for one level and `#` for the rest as its last level.
bool is_mqtt_filter(std::string_view filter);
/// Wildcards at the beginning do not match topics that begin with `$`.
bool mqtt_matches(std::string_view filter, std::string_view topic);

}  // namespace rubicon::transport
