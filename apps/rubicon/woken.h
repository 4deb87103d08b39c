#pragma once

#include <vector>

#include "apps/rubicon/selection.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

/// More devices than this are not woken without a word.
inline constexpr std::size_t kManyDevices = 20;

/// Devices of which at least one sensor's value is selected.
std::size_t woken_devices(const std::vector<client::Device>& devices, const Selections& selections);

/// Says on standard error, in a later turn of the loop, how many devices these wake, if they are many.
void tell_who_wakes(Client& client, const Selections& selections);

}  // namespace rubicon::cli
