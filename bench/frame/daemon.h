#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "support/process.h"

namespace rubicon::bench {

/// The program rubicon-proxy.
class Daemon {
 public:
  explicit Daemon(const std::string& yaml);
  /// In the tuple space of join_on_loopback(); the configuration without `tuples`.
  Daemon(const std::string& yaml, std::uint32_t domain);
  ~Daemon();
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Processor time so far, in seconds.
  double processor() const;
  /// Rounded.
  double resident_mb() const;

 private:
  std::string folder_;
  std::unique_ptr<support::Process> process_;
};

}  // namespace rubicon::bench
