#pragma once

#include <string>

#include "trust/guard/peers.h"

namespace rubicon::trust::guard {

/// As rubicon_guard_watch().
void watch(void (*call)(void* context, const std::uint8_t prefix[12], const char* name, int is_verified,
                        const char* reason),
           void* context);

struct Refused {
  GuidPrefix prefix{};
  std::string name{};        ///< empty = not known
  bool is_verified = false;  ///< the name is that of a verified certificate; else one claims it
};

/// Tells the watcher, if there is one, that a peer was refused.
void report(const Refused& peer, const std::string& reason);

}  // namespace rubicon::trust::guard
