#pragma once

#include <string>

namespace rubicon::transport {

/// Host name of this machine; empty if the system does not provide it.
std::string host_name();

/// 16 hex digits that are the same for all processes that share a boot of the kernel and a network namespace, and
/// differ for all others. The ids for two purposes cannot be derived from each other. Components declare the one for
/// `host` (tuples/link.h), whatever their engine.
std::string host_id(const std::string& purpose);

/// Process id and user of this process, for lists of components: `pid 4711 of anna`.
std::string own_process();

}  // namespace rubicon::transport
