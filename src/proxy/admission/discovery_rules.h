#pragma once

#include <string>

#include "proxy/admission/announced.h"
#include "proxy/proxy_config.h"

namespace rubicon::proxy::admission {

struct RuleResult {
  DiscoveryAction action = DiscoveryAction::kAuto;
  std::string why;  ///< which rule: `discovery.rules[2] says ask`
};
/// The action of the first rule that fits the device, else the default.
RuleResult apply_rules(const DiscoveryRules& rules, const DeviceName& device, const model::Join& join);

}  // namespace rubicon::proxy::admission
