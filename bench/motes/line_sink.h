#pragma once

#include <sys/types.h>

#include <map>
#include <utility>

#include "motes/measurements.h"

namespace rubicon::bench::motes {

struct LineSeen {
  std::uint64_t frames = 0;  ///< sent, with readings
  /// By mote and value, when the command first came: steady clock, ns.
  std::map<std::pair<int, int>, std::int64_t> commands;
};

/// A sink in a process of its own that keeps its line full: 127-byte frames of its 20 motes back to back at 115200 baud
/// to each connection, starting with its first packet. Acknowledges packets like a real sink, and commands on behalf of
/// the motes.
class LineSink {
 public:
  static constexpr int kMotes = 20;
  static constexpr std::uint16_t kFirstMote = 2;

  explicit LineSink(std::chrono::seconds readings);
  ~LineSink();
  LineSink(const LineSink&) = delete;
  LineSink& operator=(const LineSink&) = delete;

  std::uint16_t port() const { return port_; }
  /// Its counts; valid once the connection was closed, which this waits for.
  LineSeen seen();

 private:
  std::uint16_t port_ = 0;
  pid_t child_ = -1;
  int report_ = -1;
};

}  // namespace rubicon::bench::motes
