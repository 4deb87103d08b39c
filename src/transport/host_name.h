#pragma once

#include <string>

namespace rubicon::transport {

/// What this machine calls itself; empty if the system does not say.
std::string host_name();

}  // namespace rubicon::transport
