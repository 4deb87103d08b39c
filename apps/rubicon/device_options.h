#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "apps/rubicon/island_option.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

/// Options that select devices: --network, --type, --name, --area, --island.
class DeviceOptions {
 public:
  void add_to(CLI::App& app);
  /// Runs a command when the island was found that --island or --network names.
  int run(Session& session, const std::function<int(const client::DeviceQuery&)>& command);

 private:
  IslandOption island_;
  std::string network_, type_, name_, area_;
};

/// The devices that a word on the command line may mean: `living`, `dummy-rooms.living`, `proxy.dummy-rooms.living`,
/// with `6541:` in front; else a name (`Living room`) or an address.
std::vector<client::Device> devices_called(const std::vector<client::Device>& all, std::string_view word);

/// Prints the devices that `word` may mean; returns kUsage.
int ambiguous(std::string_view word, const std::vector<client::Device>& candidates);

/// Finds the one device that `word` means: kGood, or an exit code after the error was printed.
int one_device(Session& session, std::string_view word, client::Device& device);

}  // namespace rubicon::cli
