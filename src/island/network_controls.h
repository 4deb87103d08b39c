#pragma once

#include <map>
#include <memory>
#include <string>

#include "island/command_key.h"
#include "network/supervisor.h"

namespace rubicon::island {

/// The properties of networks themselves that users may set (network::Control), and the command `reopen` of each line:
/// publishes their descriptions, and gives their commands to the networks. Their values come with the state of the
/// network.
class NetworkControls {
 public:
  /// Everything must outlive it.
  NetworkControls(CommandKey::Place place, network::Supervisor& networks) : place_(place), networks_(networks) {}

  /// Networks were added, removed or recreated.
  void refresh();

 private:
  void add_line(const std::string& network);
  void add(const std::string& network, const network::Control& control);
  void add(const model::PointKey& key, const model::PointDescription& description, CommandKey::Calls calls);

  CommandKey::Place place_;
  network::Supervisor& networks_;
  std::map<std::string, std::unique_ptr<CommandKey>> all_;  ///< by key
};

}  // namespace rubicon::island
