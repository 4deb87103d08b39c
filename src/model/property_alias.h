#pragma once

#include <string>
#include <string_view>

namespace rubicon::model {

/// D1.4 writes `rate` in its figure of the tuples and "sampling-rate" in its text (docs/tuple-keys.md): the property is
/// kept as `rate`, and this other name is accepted where users type one.
inline constexpr std::string_view kSamplingRate = "sampling-rate";

/// A key as the proxy keeps it, of one that may name the property `sampling-rate`: a whole key
/// (`proxy.wsn-1.7.property.sampling-rate.command`) or a short name (`wsn-1.7.sampling-rate`, `kitchen.sampling-rate`).
/// Every other key comes back as it is.
std::string without_alias(std::string_view key);

}  // namespace rubicon::model
