#pragma once

#include <string_view>

namespace rubicon::transport {

/// 1 to 65535 bytes of UTF-8 without control characters (U+0000..001F, U+007F..009F) and noncharacters (U+FDD0..FDEF,
/// U+xxFFFE, U+xxFFFF): what each client and broker accepts (MQTT 5, section 1.5.4).
bool is_mqtt_text(std::string_view text);
/// A topic of a message (MQTT 5, section 4.7): such a text without wildcards. At most 200 levels: mosquitto
/// closes the connection of a client that subscribes or publishes to more.
bool is_mqtt_topic(std::string_view topic);
/// What a subscription may ask for: as above, with `+` for one level and `#` for the rest as its last level.
bool is_mqtt_filter(std::string_view filter);
/// Wildcards at the beginning do not match topics that begin with `$`.
bool mqtt_matches(std::string_view filter, std::string_view topic);

}  // namespace rubicon::transport
