#pragma once

#include <cstdint>
#include <string_view>

namespace rubicon::model {

/// How far a published value can be trusted; one enum everywhere (ARCHITECTURE, section 5). Ordered, worst first.
enum class Quality : std::uint8_t { kNetworkDown, kDeviceOffline, kBad, kUnknown, kStale, kStored, kAssumed, kGood };

std::string_view to_string(Quality quality);

}  // namespace rubicon::model

namespace rubicon {
using model::Quality;
}  // namespace rubicon
