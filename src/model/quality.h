#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace rubicon::model {

/// How far a published value can be trusted; one enum everywhere (ARCHITECTURE, section 5). Ordered, worst first.
enum class Quality : std::uint8_t { kNetworkDown, kDeviceOffline, kBad, kUnknown, kStale, kStored, kAssumed, kGood };

std::string_view to_string(Quality quality);
/// nullopt for every other word.
std::optional<Quality> parse_quality(std::string_view word);

}  // namespace rubicon::model

namespace rubicon {
using model::Quality;
}  // namespace rubicon
