#pragma once

#include <string>
#include <string_view>

#include "bridges/house.h"
#include "bridges/mqtt/mqtt_bridge.h"

namespace rubicon::bridges::mqtt {

/// What is published as the value: the text of the tuple, or with `payload: json` an object
/// `{"value":21.5,"unit":"Cel","quality":"good","time":1767225600.25}`, as Telegraf's parsers read it.
std::string payload_of(const PointEntry& point, const Options& options);

/// What is published as attributes, of the status of the point.
std::string attributes_of(const PointEntry& point, std::string_view status);

/// Whether what is shown of a sensor or a property is of now, or was never known.
bool is_online(const PointEntry& point);

/// Whether the property `broker` of a network names the broker of the bridge.
bool is_broker(const Options& options, std::string_view property);

}  // namespace rubicon::bridges::mqtt
