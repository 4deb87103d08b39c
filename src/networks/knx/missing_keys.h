#pragma once

#include <string>
#include <vector>

#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure_access.h"

namespace rubicon::networks::knx {

/// Adds the secured groups that have no key: a guard then sends nothing to them and takes nothing plain from them.
/// Returns them, in the order of `secured`.
std::vector<wire::GroupAddress> add_without_keys(secure::GroupKeys& keys,
                                                 const std::vector<wire::GroupAddress>& secured);

/// Names these groups and what to do, for the state of the line and for `check`; empty for no group.
std::string explain_missing_keys(const std::vector<wire::GroupAddress>& groups, const SecureOptions& options);

}  // namespace rubicon::networks::knx
