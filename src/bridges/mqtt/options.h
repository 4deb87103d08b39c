#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "rubicon/key.hpp"
#include "transport/mqtt_options.h"

namespace rubicon::bridges::mqtt {

/// How Home Assistant learns what there is.
enum class Discovery : std::uint8_t {
  kNone,
  kDevices,   ///< one message a device: Home Assistant from 2026.1, openHAB from 5.2
  kEntities,  ///< one message an entity: older ones, and others
};

/// `bridges.<name>` of type mqtt (docs/mqtt.md).
struct Options {
  transport::MqttBrokerOptions broker;
  std::string base = "rubicon";  ///< first levels of our topics
  std::string discovery_base = "homeassistant";
  Discovery discovery = Discovery::kNone;
  std::string page;                    ///< address of a page of the island, for links to devices; empty = none
  std::vector<Pattern> patterns;       ///< of values; empty = those of the own island, or of all
  std::vector<std::string> except;     ///< key patterns of values that are left out all the same
  std::vector<std::string> commands;   ///< key patterns of commands that are taken; empty = none
  std::vector<std::string> forbidden;  ///< of those that are not, though `commands` has them
  std::vector<std::string> active;     ///< key patterns of values for which sensors are sampled
  bool on_request = false;             ///< a message to `.../sample` has a sensor sampled
  bool json = false;                   ///< payloads are objects with value, unit, quality, time
  bool friendly = false;               ///< topics have the names of people
  bool keep = false;                   ///< values that are not good any longer stay retained
};

/// Reports every error to the reader.
Options read_options(ConfigReader& options, const std::string& directory);

/// Part by part: `*` in a part stands for any text, the last part `**` for any parts.
bool key_matches(std::string_view pattern, std::string_view key);
bool any_key_matches(const std::vector<std::string>& patterns, std::string_view key);

/// Whether the command with this key is taken.
bool takes_command(const Options& options, std::string_view key);

}  // namespace rubicon::bridges::mqtt
