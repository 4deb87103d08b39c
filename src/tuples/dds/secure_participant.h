#pragma once

#include "tuples/dds/dds_trust.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// The properties that make a participant take part with DDS Security: all three plug-ins are the guard's. All
/// participants of a process need the same ones, because Cyclone keeps one permissions document for all.
Qos make_secure_qos(const DdsTrust::Documents& documents, const std::string& guard_library);

/// The prefix of the GUID of a participant of this process.
GuidPrefix prefix_of_own(dds_entity_t participant);

}  // namespace rubicon::tuples::dds
