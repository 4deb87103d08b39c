#pragma once

#include <string>

namespace rubicon::transport {

/// What this machine calls itself; empty if the system does not say.
std::string host_name();

/// This process and whose it is, for lists of components: `pid 4711 of anna`.
std::string own_process();

}  // namespace rubicon::transport
