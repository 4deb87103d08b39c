#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "networks/zigbee/exposes/leaf.h"

namespace rubicon::networks::zigbee::exposes {

/// Sirens have one composite (`warning`: mode, level, strobe, duration) instead of a switch. What it means in plain
/// points, beside it: `siren`, a binary whose two values are whole objects; and of the parts that the composite has,
/// `siren_duration`, `melody` (its mode) and `alarm_volume`, settings that no message holds: they are for the next
/// `siren` on. Empty if the leaf is no such composite: it can be set, and its `mode` has the word `stop` and another
/// one.
std::vector<Leaf> siren_leaves(const Leaf& leaf);

/// The object of a command with other values of these parts: JSON by name.
std::string with_parts(std::string_view object, const std::map<std::string, std::string>& parts);

}  // namespace rubicon::networks::zigbee::exposes
