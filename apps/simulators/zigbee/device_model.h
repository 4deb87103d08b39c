#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/simulators/zigbee/definition_generator.h"
#include "rubicon/time.hpp"

namespace rubicon::zigbee_simulator {

/// What all devices of a model have in common: their definition, and how they behave.
struct DeviceModel {
  nlohmann::json definition;                          ///< of the record in `bridge/devices`
  std::string manufacturer, model_id;                 ///< as the device says at its interview
  bool battery = false;                               ///< otherwise mains powered, and a router
  bool sleeps = false;                                ///< takes commands only when it reports, and answers no `get`
  nlohmann::json endpoints;                           ///< of the record, once the device is configured
  std::map<std::string, std::string> cluster;         ///< property -> cluster; each cluster is reported in one message
  nlohmann::json values;                              ///< property -> what the device has at first
  nlohmann::json known;                               ///< further members of its state messages
  std::map<std::string, std::array<double, 3>> walk;  ///< measured: lowest, highest, largest step between two reports
  std::set<std::string> no_echo;                      ///< properties whose set the bridge does not echo

  /// A property that the bridge sets back by itself: an occupancy that no report ended.
  struct Clearing {
    std::string property;
    nlohmann::json value;
    Duration after{};
  };
  std::optional<Clearing> clears{};

  std::map<std::string, std::vector<nlohmann::json>> leaves;  ///< property -> its leaves in `exposes`
};

/// lamp, plug, thermometer, motion, contact, cover, lock, trv, remote, switch, relay, weather.
std::vector<std::string> model_names();
std::optional<DeviceModel> find_model(std::string_view name);
/// A model with a random definition (see DefinitionGenerator) and values that fit.
DeviceModel make_model(DefinitionGenerator& generator, std::uint32_t index);

/// The JSON form of the built-in models.
DeviceModel read_model(std::string_view json);

/// The bits of `access` (zigbee.md, section 3.1).
bool is_published(const nlohmann::json& leaf);
bool is_settable(const nlohmann::json& leaf);
bool is_gettable(const nlohmann::json& leaf);
/// Whether the bridge can send this value to the device: one of the words, within the bounds. Everything else it only
/// logs.
bool accepts(const nlohmann::json& leaf, const nlohmann::json& value);

}  // namespace rubicon::zigbee_simulator
