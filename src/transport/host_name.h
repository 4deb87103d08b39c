#pragma once

#include <string>

namespace rubicon::transport {

/// Host name of this machine; empty if the system does not provide it.
std::string host_name();

/// Process id and user of this process, for lists of components: `pid 4711 of anna`.
std::string own_process();

}  // namespace rubicon::transport
