#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frame/figures.h"
#include "support/process.h"

namespace rubicon::bench::web {

/// Plays `--island DEVICES PORT` or `--publisher DEVICES PORT` if the command line says so, until its input ends, and
/// gives the exit code. The island has generated devices and serves the page at PORT (0 = any free one) as
/// rubicon-proxy does; the publisher publishes the same values to an MQTT broker at PORT. It prints `ready PORT`, and
/// reads lines: `rate N` (updates a second) and `made`, both answered by the number of updates so far.
std::optional<int> play_role(int argc, char** argv);

/// Another process of this program in a role.
class RoleProcess {
 public:
  RoleProcess(const std::string& role, int devices, int port = 0);

  int port() const { return port_; }
  /// How many updates were made so far.
  std::uint64_t set_rate(int rate);
  std::uint64_t made();
  pid_t pid() const { return process_.pid(); }
  /// Processor time so far, in seconds.
  double processor() const;
  double resident_mb() const;

 private:
  std::string ask(const std::string& line);

  support::Process process_;
  int port_ = 0;
};

}  // namespace rubicon::bench::web
