#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "model/point_tuples.h"
#include "rubicon/client.hpp"

namespace rubicon::web::api {

/// The descriptions of points, by the key of the point.
using PointDescriptions = std::map<std::string, model::PointDescription, std::less<>>;
/// Those of one island among the tuples.
PointDescriptions point_descriptions(const std::vector<client::Tuple>& tuples, OwnerId island);

/// The device as a W3C Web of Things Thing Description 1.1: points with a state are properties, points with events are
/// events. Addresses are relative to that of the description.
nlohmann::ordered_json thing_description(const client::Device& device, const PointDescriptions& points,
                                         bool needs_token);

}  // namespace rubicon::web::api
