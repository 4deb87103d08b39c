#pragma once

#include <string>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/interfaces.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::tuples::dds {

/// kIo if one of options.interfaces does not exist, is down, has no address, or has no multicast where it is needed.
/// The text says what to do.
Result<void> check_interfaces(const DdsOptions& options, const std::vector<transport::Interface>& present);

/// Replaces host names (also before `:port`) by their first IPv4 addresses. Names that cannot be resolved stay and are
/// added to `unknown`. Blocks for the system's resolver; names left after the timeout count as unknown.
std::vector<std::string> with_addresses(std::vector<std::string> peers, Scheduler& scheduler, Duration timeout,
                                        std::vector<std::string>& unknown);
/// Whether the host of `peer` is a numeric IPv4 address.
bool has_address(const std::string& peer);

}  // namespace rubicon::tuples::dds
