#include "networks/log/recorded_networks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/point_keys.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::log {

namespace {

constexpr std::size_t kMaxNetworks = 1000;

/// `wsn-1.7.sensor.light-1.value` and `wsn-1.status`.
bool names_network(const std::vector<std::string_view>& parts) {
  if (parts.empty() || model::is_part_of_island(parts[0])) return false;
  if (parts.size() == 2) return parts[1] == "status";
  return parts.size() == 5 && (parts[2] == "sensor" || parts[2] == "actuator" || parts[2] == "property");
}

}  // namespace

bool RecordedNetworks::note(const std::vector<std::string_view>& parts) {
  if (!names_network(parts) || names_.contains(parts[0])) return false;
  if (names_.size() >= kMaxNetworks || parts[0] != model::to_key_part(parts[0])) return false;
  names_.emplace(parts[0]);
  return true;
}

Error RecordedNetworks::ambiguous() const {
  return {ErrorCode::kInvalid,
          fmt::format(
              "the recording holds the networks {}; choose one with the option `network`, for example `network: {}`",
              fmt::join(names_, ", "), *names_.begin())};
}

}  // namespace rubicon::networks::log
