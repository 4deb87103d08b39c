#pragma once

#include <string>

#include "proxy/proxy_config.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::proxy {

/// The name of a component for people, from its summary: `rubicon set (pid 4711 of anna)`, ` on HOST` with it if that
/// is another one, `flat (island 2)`; `component 70001` if it has no summary. Printable, at most some 200 bytes.
std::string commander_name(const TupleSpace& space, const ProxyConfig& config, OwnerId id);

}  // namespace rubicon::proxy
