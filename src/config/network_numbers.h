#pragma once

#include "base/config_node.h"

namespace rubicon::config {

/// `networks: [{type: wsn}, {type: knx}, {type: wsn}]` becomes a map of wsn-1, knx-1 and wsn-2: each is numbered by its
/// place among those of its type (D1.4, chapter 3: "By default this is a number automatically generated"). Anything
/// but a list is left alone. What has no type is called network-<place>, and refused by who reads it.
void number_networks(ConfigNode& root);

}  // namespace rubicon::config
