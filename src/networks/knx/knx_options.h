#pragma once

#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/capture.h"
#include "networks/knx/exposures.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/knx_line.h"
#include "networks/knx/secure_access.h"

namespace rubicon::networks::knx {

/// The options of a network of `type: knx`.
struct KnxOptions {
  LineOptions line;
  SecureOptions secure;
  std::vector<groups::GroupPoint> points;
  std::vector<wire::GroupAddress> secured;  ///< groups that are secured by the import or the options; sorted
  std::vector<Exposure> exposures;
  Capture::Limits capture;
  wire::Notation notation = wire::Notation::kThreeLevel;  ///< of group addresses in texts for people, not in keys
  std::string report;  ///< summary of the import, for the log; empty = nothing was imported
};

/// Reads all options and the file that `import` names. Errors are added to those of the reader. Groups of the
/// configuration replace the same addresses of that file.
KnxOptions read_knx_options(const network::NetworkConfig& config, transport::Transports& transports);

}  // namespace rubicon::networks::knx
