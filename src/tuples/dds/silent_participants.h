#pragma once

#include <dds/dds.h>

#include <set>

#include "tuples/dds/dds_trust.h"

namespace rubicon::tuples::dds {

/// The participants of the domain that DDS knows, those of this process too. With and without security DDS knows those
/// of the other kind: it refuses their writers and readers only.
std::set<GuidPrefix> participants_in_domain(dds_entity_t participant);

/// Those that have a writer which the reader is matched with.
std::set<GuidPrefix> participants_matched(dds_entity_t reader);

}  // namespace rubicon::tuples::dds
