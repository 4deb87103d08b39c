#pragma once

#include <string>

#include "trust/guard/peers.h"

namespace rubicon::trust::guard {

/// As rubicon_guard_watch().
void watch(void (*call)(void* context, const std::uint8_t prefix[12], const char* name, const char* reason),
           void* context);

/// Tells the watcher, if there is one, that a peer was refused.
void report(const GuidPrefix& prefix, const std::string& name, const std::string& reason);

}  // namespace rubicon::trust::guard
