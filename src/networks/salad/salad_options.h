#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/salad/salad_codec.h"

namespace rubicon::networks::salad {

/// A device of the table, `device_<id> = <name>,<type>[,<actuator id>]` (salad.md, section 5).
struct SaladDevice {
  std::string name;      ///< symbolic: `TV_STATE`
  std::string type;      ///< as SALAD calls it: `sensor.soundrecognition.confidence`
  std::string actuator;  ///< target of commands; empty = it takes none
  TypeId type_id{};      ///< in the catalogue
  bool sensor = true;    ///< its type is that of a sensor; with an actuator id it is both

  friend bool operator==(const SaladDevice&, const SaladDevice&) = default;
};

/// The options of a `type: salad` network, from its configuration and the original's properties file.
struct SaladOptions {
  std::string host = "localhost";
  std::uint16_t port = 9000;
  std::uint16_t own_port = 9100;                                   ///< 0 = any free port
  std::size_t buffer = 2048;                                       ///< longest datagram, in bytes
  bool any_source = false;                                         ///< accept datagrams from any host
  std::optional<Duration> start_again = std::chrono::seconds(10);  ///< after this silence updates are requested again
  std::map<DeviceId, SaladDevice> devices;
  std::vector<std::string> unknown_keys;  ///< of the properties file
};

/// Reads the options and the properties file that they name; mistakes are added to the reader's errors, with the line
/// in the properties file. A key of the configuration has priority over the same key of that file.
SaladOptions read_salad_options(const network::NetworkConfig& config, transport::Transports& transports);

/// Reads `<name>,<type>[,<actuator id>]`; kInvalid with the reason.
Result<SaladDevice> read_device(std::string_view line, const TypeCatalogue& types);

/// The Join of a device: a sensor or an actuator by its type, both if a sensor takes commands (device 28 of salad.md,
/// section 5.1). `heard` is false, as it precedes any contact.
model::Join join_of(const SaladDevice& device);

/// The same reading for all points of the device. Booleans are 1 and 0; any other number stays a number, which the
/// proxy marks as bad. There is no user time.
model::Updates updates_of(const SaladDevice& device, const Type& type, const Value& value);

/// The number to be sent for a command: 1 and 0 for on and off, whole numbers as they are. Otherwise kRefused,
/// kNotFound, kInvalid or kOutOfRange.
Result<std::int64_t> command_of(const SaladDevice& device, const Type& type, const model::Actuate& command);

}  // namespace rubicon::networks::salad
