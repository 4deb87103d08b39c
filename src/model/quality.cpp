#include "model/quality.h"

namespace rubicon::model {

std::string_view to_string(Quality quality) {
  switch (quality) {
    case Quality::kNetworkDown: return "network-down";
    case Quality::kDeviceOffline: return "device-offline";
    case Quality::kBad: return "bad";
    case Quality::kUnknown: return "unknown";
    case Quality::kStale: return "stale";
    case Quality::kStored: return "stored";
    case Quality::kAssumed: return "assumed";
    case Quality::kGood: return "good";
  }
  return "unknown";
}

std::optional<Quality> parse_quality(std::string_view word) {
  for (auto quality = Quality::kNetworkDown; quality <= Quality::kGood;
       quality = static_cast<Quality>(static_cast<std::uint8_t>(quality) + 1)) {
    if (to_string(quality) == word) return quality;
  }
  return std::nullopt;
}

}  // namespace rubicon::model
