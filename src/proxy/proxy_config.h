#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::proxy {

/// What a number must be to be believed (docs/types.md, "Plausible values").
struct Valid {
  std::optional<double> minimum, maximum;    ///< in the unit of the type
  std::optional<double> step;                ///< largest difference to the last good value
  bool rises = false;                        ///< a counter: never below the last good value
  std::optional<std::vector<double>> never;  ///< codes for "no value"; absent = those known for the type

  friend bool operator==(const Valid&, const Valid&) = default;
};

/// Names given to one device at installation time. Keys of the maps are default ids (`light-1`), values the instance
/// that replaces theirs (`window` -> `light-window`).
struct DeviceNames {
  std::string id;    ///< key part instead of the address; empty = the address
  std::string name;  ///< for people; empty = from a user or the device
  std::string area;  ///< room or place; empty = from a user
  std::map<std::string, std::string> sensors;
  std::map<std::string, std::string> actuators;
  std::map<std::string, Valid> valid;  ///< plausible values of a point, by its default id

  friend bool operator==(const DeviceNames&, const DeviceNames&) = default;
};

struct NetworkRules {
  std::optional<Duration> silence = std::chrono::seconds(60);  ///< nullopt = never unreachable by silence
  std::chrono::milliseconds rate{1000};                        ///< sampling period where no subscriber names one
  std::map<std::string, Valid> valid;                          ///< by type, for all its devices
  std::map<std::string, DeviceNames> devices;                  ///< by address, or announced name (adopt_names())
  std::string roaming;         ///< domain within which an address means one device; empty = none
  bool lists_devices = false;  ///< its options name all its devices (NetworkType::lists_devices)
  bool discovers = false;      ///< a device that was not heard may be new (NetworkType::discovers)
  bool probes = false;         ///< quiet devices are sent a Probe (NetworkType::probes)
  bool unique_names = false;   ///< the keys of `devices` may also be names (NetworkType::unique_names)
  Duration answer_time{0};     ///< NetworkType::answer_time

  friend bool operator==(const NetworkRules&, const NetworkRules&) = default;
};

/// What happens to a device that announces itself and is neither known nor named in the configuration.
enum class DiscoveryAction : std::uint8_t { kAuto, kAsk, kIgnore };
std::string_view to_string(DiscoveryAction action);

/// For devices of some networks, types or addresses; `*` and `?` stand for any text and any character, empty = any.
struct DiscoveryRule {
  std::string network, type, address;
  DiscoveryAction action = DiscoveryAction::kAuto;

  friend bool operator==(const DiscoveryRule&, const DiscoveryRule&) = default;
};

struct DiscoveryRules {
  DiscoveryAction otherwise = DiscoveryAction::kAuto;
  std::vector<DiscoveryRule> rules;  ///< the first that fits applies

  friend bool operator==(const DiscoveryRules&, const DiscoveryRules&) = default;
};

struct ProxyConfig {
  std::string prefix = "proxy";
  std::string island_name;
  std::string host;                                         ///< this machine; empty = every host is another one
  Duration command_time_to_live = std::chrono::seconds(5);  ///< of commands that carry none
  Duration confirmation_wait = std::chrono::seconds(5);
  Duration queue_expiry = std::chrono::hours(24);  ///< no command waits longer, whatever its time to live
  std::size_t max_devices = 20000;
  Duration save_period = std::chrono::seconds(10);  ///< how often changed values are written to the state file
  DiscoveryRules discovery;
  std::map<std::string, NetworkRules> networks;  ///< by network id; all networks of the island
};

}  // namespace rubicon::proxy
