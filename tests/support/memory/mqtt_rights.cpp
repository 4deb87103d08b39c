#include "support/memory/mqtt_rights.h"

#include <algorithm>

#include "transport/mqtt.h"

namespace rubicon::transport {

namespace {

bool pattern_allows(std::string pattern, std::string_view user, std::string_view topic) {
  constexpr std::string_view kUser = "%u";
  for (auto at = pattern.find(kUser); at != pattern.npos; at = pattern.find(kUser, at + user.size())) {
    if (user.empty()) return false;
    pattern.replace(at, kUser.size(), user);
  }
  return mqtt_matches(pattern, topic);
}

bool any_allows(const std::vector<std::string>& patterns, std::string_view user, std::string_view topic) {
  if (user.find_first_of("+#") != user.npos) return false;
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const auto& pattern) { return pattern_allows(pattern, user, topic); });
}

}  // namespace

bool MqttRights::may_read(std::string_view user, std::string_view topic) const {
  return any_allows(read, user, topic);
}

bool MqttRights::may_write(std::string_view user, std::string_view topic) const {
  return any_allows(write, user, topic);
}

std::string MqttRights::text() const {
  std::string lines;
  for (const auto& pattern : read) lines += "pattern read " + pattern + "\n";
  for (const auto& pattern : write) lines += "pattern write " + pattern + "\n";
  return lines;
}

}  // namespace rubicon::transport
