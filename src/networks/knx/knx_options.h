#pragma once

#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/capture.h"
#include "networks/knx/exposures.h"
#include "networks/knx/groups/group_point.h"
#include "networks/knx/knx_line.h"

namespace rubicon::networks::knx {

/// What a `type: knx` network is told.
struct KnxOptions {
  LineOptions line;
  std::vector<groups::GroupPoint> points;
  std::vector<Exposure> exposures;
  Capture::Limits capture;
  std::string report;  ///< what the import said, for the log; empty = nothing to say
};

/// Reads all options and the file that `import` names; what is wrong stands in the reader's errors. Groups of the
/// configuration go before the same addresses of that file.
KnxOptions read_knx_options(const network::NetworkConfig& config, transport::Transports& transports);

}  // namespace rubicon::networks::knx
