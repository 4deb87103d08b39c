#include "proxy/admission/discovery_rules.h"

#include <fmt/format.h>

#include "base/glob.h"

namespace rubicon::proxy::admission {

namespace {

bool fits(const std::string& pattern, std::string_view text) {
  return pattern.empty() || base::glob_matches(pattern, text);
}

}  // namespace

RuleResult apply_rules(const DiscoveryRules& discovery, const DeviceName& device, const model::Join& join) {
  for (std::size_t i = 0; i < discovery.rules.size(); ++i) {
    const auto& rule = discovery.rules[i];
    if (!fits(rule.network, device.network) || !fits(rule.type, join.device_type) ||
        !fits(rule.address, device.address))
      continue;
    return {rule.action, fmt::format("discovery.rules[{}] says {}", i, to_string(rule.action))};
  }
  return {discovery.otherwise, fmt::format("discovery.new-devices is {}", to_string(discovery.otherwise))};
}

}  // namespace rubicon::proxy::admission
