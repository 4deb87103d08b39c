#include "proxy/proxy_config.h"

namespace rubicon::proxy {

std::string_view to_string(DiscoveryAction action) {
  switch (action) {
    case DiscoveryAction::kAuto: return "auto";
    case DiscoveryAction::kAsk: return "ask";
    case DiscoveryAction::kIgnore: return "ignore";
  }
  return "auto";
}

}  // namespace rubicon::proxy
