#pragma once

#include <map>
#include <optional>
#include <string>

#include "base/time.h"

namespace rubicon::proxy {

/// Names given at installation time to one device; keys are the default ids (`light-1`), values the instance part that
/// replaces theirs (`window` -> `light-window`).
struct DeviceNames {
  std::string id;    ///< key part instead of the address; empty = the address
  std::string name;  ///< for people; empty = what the device says
  std::map<std::string, std::string> sensors;
  std::map<std::string, std::string> actuators;
};

struct NetworkRules {
  std::optional<Duration> silence = std::chrono::seconds(60);  ///< nullopt = never unreachable by silence
  std::chrono::milliseconds rate{1000};                        ///< sampling period where nobody names one
  std::map<std::string, DeviceNames> devices;                  ///< by address
};

struct ProxyConfig {
  std::string prefix = "proxy";
  std::string island_name;
  Duration command_time_to_live = std::chrono::seconds(5);
  Duration confirmation_wait = std::chrono::seconds(5);
  Duration queue_expiry = std::chrono::seconds(60);
  std::size_t max_devices = 20000;
  std::map<std::string, NetworkRules> networks;  ///< by network id; every network of the island stands here
};

}  // namespace rubicon::proxy
