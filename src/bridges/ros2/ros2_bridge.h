#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "bridges/bridge.h"
#include "bridges/scope.h"

namespace rubicon::bridges::ros2 {

/// Shows points as topics of ROS 2, takes commands from there, and makes tuples of topics of robots (docs/ros2.md). As
/// BridgeType::make.
std::unique_ptr<Bridge> make(ConfigReader& options, const std::string& directory, const BridgeHost* host);

/// Which form of `ros_discovery_info` the robots read.
enum class Distribution : std::uint8_t { kAuto, kHumble, kJazzy, kNone };

/// One topic of a robot that becomes tuples.
struct ImportRule {
  std::string topic;   ///< ROS name
  std::string device;  ///< part of the key
  std::string id;      ///< of the sensor, `battery-1`; empty: all values in the message
  std::string type;    ///< of our catalogue; with an id never empty
  std::string part;    ///< which value of the message; empty: the first of that type, else the first
};

/// How others are found, from the options, else from the environment.
struct Reach {
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces = {"lo"};  ///< empty = those that Cyclone DDS chooses
  std::vector<std::string> peers;                ///< HOST or HOST:PORT
  bool discovers = true;                         ///< false: ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
  std::string cyclone;                           ///< CYCLONEDDS_URI: settings that go before ours
};
inline constexpr std::uint32_t kMaxRosDomain = 232;  ///< higher ones would have ports above 65535

/// `bridges.<name>` of type ros2.
struct Options : Scope {
  Reach reach;
  std::string name_space;  ///< first token of our topics; empty = the name of the island
  Distribution distribution = Distribution::kAuto;
  Duration diagnostics = std::chrono::seconds(1);  ///< zero = none
  std::vector<ImportRule> imports;
  bool imports_all = false;  ///< each topic of a form that we know
};

/// Gives the text of a variable of the environment; empty = not set.
using Environment = std::function<std::string(const char* name)>;
/// Reports every error to the reader.
Options read_options(ConfigReader& options, const Environment& environment);

/// The configuration of the domain for Cyclone DDS (https://cdds.io/config).
std::string domain_xml(const Reach& reach);

}  // namespace rubicon::bridges::ros2
