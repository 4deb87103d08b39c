#pragma once

#include <string>

namespace rubicon::support {

// The programs under test, and the island file of the SALAD flat.
inline const std::string kDaemon = RUBICON_BINARY_DIR "/bin/rubicon-proxy";
inline const std::string kMotes = RUBICON_BINARY_DIR "/bin/motes-simulator";
inline const std::string kSimulator = RUBICON_BINARY_DIR "/bin/salad-simulator";
inline const std::string kKnxSimulator = RUBICON_BINARY_DIR "/bin/knx-simulator";
inline const std::string kZigbeeSimulator = RUBICON_BINARY_DIR "/bin/zigbee-simulator";
inline const std::string kFlat = RUBICON_SOURCE_DIR "/examples/salad.yaml";

}  // namespace rubicon::support
