#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/salad/salad_codec.h"

namespace rubicon::networks::salad {

/// One line of the device table, `device_<id> = <name>,<type>[,<actuator id>]` (salad.md, section 5).
struct SaladDevice {
  std::string name;      ///< symbolic: `TV_STATE`
  std::string type;      ///< as SALAD calls it: `sensor.soundrecognition.confidence`
  std::string actuator;  ///< what commands go to; empty = it takes none
  TypeId type_id{};      ///< in the catalogue
  bool sensor = true;    ///< by its type; a sensor with an actuator id is both

  friend bool operator==(const SaladDevice&, const SaladDevice&) = default;
};

/// What a `type: salad` network is told, by its configuration and by the original's properties file.
struct SaladOptions {
  std::string host = "localhost";
  std::uint16_t port = 9000;
  std::uint16_t own_port = 9100;                                   ///< 0 = any free one
  std::size_t buffer = 2048;                                       ///< longest datagram, in bytes
  bool any_source = false;                                         ///< take datagrams from any host
  std::optional<Duration> start_again = std::chrono::seconds(10);  ///< silence after which updates are asked for again
  std::map<DeviceId, SaladDevice> devices;
  std::vector<std::string> unknown_keys;  ///< of the properties file
};

/// Reads all options and the properties file they name; what is wrong stands in the reader's errors, with the line of
/// the properties file where it stands there. A key of the configuration goes before the same key of that file.
SaladOptions read_salad_options(const network::NetworkConfig& config, transport::Transports& transports);

/// `<name>,<type>[,<actuator id>]` -> a device; kInvalid says what is wrong with it.
Result<SaladDevice> read_device(std::string_view line, const TypeCatalogue& types);

}  // namespace rubicon::networks::salad
