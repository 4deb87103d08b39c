#pragma once

#include <string>

#include "island/island.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::daemon {

/// JSON {interfaces: [{name, address, lack}], changes, changed: seconds since 1970, 0 = never}; empty: there is no
/// news.
std::string interfaces_text(const tuples::dds::InterfaceNews& news);
/// The island shows it as `<prefix>.property.dds-interfaces.value`. The ecology must outlive it.
void show_interfaces(island::Island& island, const tuples::dds::DdsEcology& ecology);

}  // namespace rubicon::daemon
