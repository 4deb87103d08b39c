#pragma once

#include <dds/dds.h>
#include <dds/ddsc/dds_rhc.h>

#include "tuples/dds/entity.h"
#include "tuples/dds/instance_quota.h"

namespace rubicon::tuples::dds {

/// Stands before the store of a reader (Cyclone calls it a reader history cache) and lets in what the quota has room
/// for. A filter of the topic would not do: Cyclone asks it about values only, and keeps an instance of each dispose.
/// Outlives its reader.
class GuardedStore {
 public:
  explicit GuardedStore(InstanceQuota& quota);
  GuardedStore(const GuardedStore&) = delete;
  GuardedStore& operator=(const GuardedStore&) = delete;

  /// One at a time.
  dds_entity_t make_reader(dds_entity_t parent, dds_entity_t topic, const dds_qos_t* qos,
                           const dds_listener_t* listener);

  /// What Cyclone has of it.
  struct Face {
    dds_rhc head;  ///< first: Cyclone knows the rest by it
    dds_rhc* store;
    InstanceQuota* quota;
  };

 private:
  Face face_;
};

}  // namespace rubicon::tuples::dds
