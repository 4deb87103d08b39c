#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/config_node.h"
#include "island/island.h"

namespace rubicon::daemon {

/// Where things stand in a configuration file that was read before. Reads it again when it is first asked: only who
/// found something wrong needs it.
class ConfigPlaces {
 public:
  ConfigPlaces(std::string file, std::vector<std::string> overrides)
      : file_(std::move(file)), overrides_(std::move(overrides)) {}

  /// `home.yaml:3:7` of the deepest part of the path that is there.
  std::string of(const std::vector<std::string>& path) const;

 private:
  std::string file_;
  std::vector<std::string> overrides_;
  mutable std::optional<ConfigNode> root_;
};

/// Lines for the user, each with its place.
struct HostCheck {
  /// What the configuration names and this host does not have: recordings, folders that are written to, interfaces,
  /// certificates.
  std::vector<std::string> lacking;
  std::vector<std::string> wrong;  ///< on each host, such as the password of a file
  std::vector<std::string> warnings;
};
HostCheck check_host(island::Island& island, transport::Transports& transports, const ConfigPlaces& places);

}  // namespace rubicon::daemon
