#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/type_catalogue.h"
#include "rubicon/client.hpp"

// The one form of devices, points and components in JSON: that of the command line (docs/cli.md).
namespace rubicon::client {

nlohmann::ordered_json device_json(const Device& device);

/// A sensor, actuator or property in the description of a device.
struct Place {
  Kind kind;
  std::string id;
};
std::vector<Place> places_of(const Device& device);

/// What the tuples of a point say, as texts; empty = there is none.
struct PlaceTexts {
  std::string value, status, description;
};
/// kind, id, key, value, status, description
nlohmann::ordered_json place_json(const Device& device, const Place& place, const PlaceTexts& texts);

/// tuple_json() with creator, expire, and present where the owner is absent.
nlohmann::ordered_json whole_tuple_json(const Tuple& tuple);

}  // namespace rubicon::client
