#pragma once

#include <vector>

#include "trust/site/site_issuer.h"
#include "trust/site/site_operations.h"

namespace rubicon::trust::site {

/// All files of a broker, with a certificate for its hosts. Its key stays if there is one.
Result<void> write_broker(const SiteIssuer& issuer, const BrokerFolder& broker);
/// What changes with members: access list, revocation list, passwords. In each folder of the realm.
std::vector<BrokerUpdate> update_brokers(const SiteIssuer& issuer);

}  // namespace rubicon::trust::site
