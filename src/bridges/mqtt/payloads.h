#pragma once

#include <string>

#include "bridges/mqtt/house.h"

namespace rubicon::bridges::mqtt {

/// What is published as the value: the text of the tuple, or with `payload: json` an object
/// `{"value":21.5,"unit":"Cel","quality":"good","time":1767225600.25}`, as Telegraf's parsers read it.
std::string payload_of(const PointEntry& point, const Options& options);

/// Whether what is shown of a sensor or a property is of now, or was never known.
bool is_online(const PointEntry& point);

}  // namespace rubicon::bridges::mqtt
