#pragma once

#include "networks/salad/salad_options.h"

namespace rubicon::networks::salad {

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
