#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rubicon::transport {

/// Lines `pattern read FILTER` and `pattern write FILTER` of an `acl_file` of mosquitto (mosquitto.conf(5)); %u stands
/// for the user. What no line allows is forbidden. As mosquitto 2.0.11: a user with + or # may nothing, and without a
/// user lines with %u do not count; a user with / is taken as it is, which gives it what belongs to others.
struct MqttRights {
  std::vector<std::string> read, write;

  bool may_read(std::string_view user, std::string_view topic) const;
  bool may_write(std::string_view user, std::string_view topic) const;
  /// As an `acl_file`.
  std::string text() const;
};

}  // namespace rubicon::transport
