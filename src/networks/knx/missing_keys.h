#pragma once

#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure_access.h"

namespace rubicon::networks::knx {

/// Adds the secured groups that have no key: a guard then sends nothing to them and takes nothing plain from them.
/// Returns them, in the order of `secured`.
std::vector<wire::GroupAddress> add_without_keys(secure::GroupKeys& keys,
                                                 const std::vector<wire::GroupAddress>& secured);

/// Names these groups and what to do, for the state of the line and for `check`; empty for no group.
std::string explain_missing_keys(const std::vector<wire::GroupAddress>& groups, const SecureOptions& options);

/// What KNX Secure lacks, for `check`: passwords are tried, which takes some 15 ms each. `secured`: the groups that the
/// import or the options secure.
void add_missing_keys(const SecureOptions& secure, const LineOptions& line,
                      const std::vector<wire::GroupAddress>& secured, bool remembers,
                      std::vector<network::Missing>& all);

}  // namespace rubicon::networks::knx
