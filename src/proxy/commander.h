#pragma once

#include <string>

#include "proxy/proxy_context.h"

namespace rubicon::proxy {

/// A component as people know it, by its summary: `rubicon set (pid 4711 of anna)`, ` on HOST` with it if that is
/// another one, `flat (island 2)`; `component 70001` if it says nothing of itself. Printable, at most some 200 bytes.
std::string commander_name(const ProxyContext& context, OwnerId id);

}  // namespace rubicon::proxy
