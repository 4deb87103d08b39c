#pragma once

#include "tuples/dds/instance_quota.h"
#include "tuples/dds/interests.h"
#include "tuples/dds/participants.h"

namespace rubicon::tuples::dds {

/// What the topics of presence and interests use, on the threads of DDS too: it has to live as long as they do.
struct ReaderStores {
  InstanceQuota presence_quota{2 * Participants::kMaxComponents}, interest_quota{Interests::kMaxOfOne};
};

}  // namespace rubicon::tuples::dds
