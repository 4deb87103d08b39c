#pragma once

#include <string>

namespace rubicon::daemon {

/// `rubicon-proxy trust-key FILE`: prints the path of the key of the island's member, which root's unit hands to the
/// service. An error, and no line, if the island has no trust or no member of this host; its exit code.
int print_trust_key(const std::string& file);

}  // namespace rubicon::daemon
