#pragma once

#include <optional>
#include <string>
#include <vector>

#include "island/island_config.h"
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

/// One process reads a serial line: two networks on the same device are an error, at the later one.
void check_serial_lines(const IslandConfig& config, base::ConfigErrors& errors);

/// A port that two options of the whole file open, such as `local-port` of two networks, or `web.listen` and `share`,
/// is an error, at the later one.
void check_ports(const ConfigNode& root, base::ConfigErrors& errors);

}  // namespace rubicon::island
