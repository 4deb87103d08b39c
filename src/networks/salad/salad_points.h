#pragma once

#include "networks/salad/salad_options.h"

namespace rubicon::networks::salad {

/// A sensor by its type, an actuator by its type, both where a sensor takes commands (device 28 of salad.md,
/// section 5.1). Not heard: nobody spoke with it yet.
model::Join join_of(const SaladDevice& device);

/// One reading, at all points of the device. On and off types take 1 and 0; a number that is neither stays one, for the
/// proxy to call bad. SALAD tells no time.
model::Updates updates_of(const SaladDevice& device, const Type& type, const Value& value);

/// What is sent for a command: on and off as 1 and 0, whole numbers as they are. Else kRefused, kNotFound, kInvalid,
/// kOutOfRange.
Result<std::int64_t> command_of(const SaladDevice& device, const Type& type, const model::Actuate& command);

}  // namespace rubicon::networks::salad
