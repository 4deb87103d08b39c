#pragma once

#include <chrono>
#include <string>
#include <thread>

#include "support/process.h"

namespace rubicon::support {

// The programs under test, and the island file of the SALAD flat.
inline const std::string kDaemon = RUBICON_BINARY_DIR "/bin/rubicon-proxy";
inline const std::string kMotes = RUBICON_BINARY_DIR "/bin/motes-simulator";
inline const std::string kSimulator = RUBICON_BINARY_DIR "/bin/salad-simulator";
inline const std::string kKnxSimulator = RUBICON_BINARY_DIR "/bin/knx-simulator";
inline const std::string kZigbeeSimulator = RUBICON_BINARY_DIR "/bin/zigbee-simulator";
inline const std::string kFlat = RUBICON_SOURCE_DIR "/examples/salad.yaml";

/// Waits until another process finds a text in the export of a state file; false after a minute.
inline bool until_saved(const std::string& file, const std::string& text) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(50))) {
    if (run_to_end({kDaemon, "state", file, "export"}).output.find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace rubicon::support
