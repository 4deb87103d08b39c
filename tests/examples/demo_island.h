#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"

namespace rubicon::examples {

/// What `./run` starts, in a network of its own, and a folder with the files that examples name.
class DemoIsland {
 public:
  DemoIsland();
  ~DemoIsland();
  DemoIsland(const DemoIsland&) = delete;
  DemoIsland& operator=(const DemoIsland&) = delete;

  /// Empty: it runs. Else why it cannot be run here.
  const std::string& reason() const { return network_.reason(); }
  const std::filesystem::path& folder() const { return folder_; }

  /// A shell command line in that folder, ended with SIGINT after so many seconds.
  std::vector<std::string> command(const std::string& line, int seconds) const;

 private:
  void write_files() const;
  void start_broker();

  support::PrivateNetwork network_;
  std::filesystem::path folder_;
  std::unique_ptr<support::Mosquitto> broker_;
  std::vector<std::unique_ptr<support::Process>> running_;
};

}  // namespace rubicon::examples
