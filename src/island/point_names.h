#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/type_catalogue.h"
#include "network/network.h"
#include "proxy/naming.h"
#include "proxy/proxy_config.h"

namespace rubicon::island {

/// Names in `devices:` of a network that fit none of the devices and points it lists, with paths such as `2`,
/// `sensors`, `lihgt-1`; some fifty of them at most; none if it lists nothing.
std::vector<proxy::LostName> lost_names(const proxy::NetworkRules& rules,
                                        const std::optional<std::vector<network::ListedDevice>>& listed,
                                        const TypeCatalogue& types);

}  // namespace rubicon::island
