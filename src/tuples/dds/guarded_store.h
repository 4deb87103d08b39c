#pragma once

#include <dds/dds.h>
#include <dds/ddsc/dds_rhc.h>

#include "tuples/dds/entity.h"
#include "tuples/dds/instance_quota.h"

namespace rubicon::tuples::dds {

/// Wraps the store of a reader (Cyclone: reader history cache) and drops samples beyond the quota. A topic filter is
/// not enough: Cyclone applies it to values only, and keeps an instance for each dispose. Outlives its reader.
class GuardedStore {
 public:
  explicit GuardedStore(InstanceQuota& quota);
  GuardedStore(const GuardedStore&) = delete;
  GuardedStore& operator=(const GuardedStore&) = delete;

  /// At most one reader at a time.
  dds_entity_t make_reader(dds_entity_t parent, dds_entity_t topic, const dds_qos_t* qos,
                           const dds_listener_t* listener);

  /// The part that Cyclone has a pointer to.
  struct Face {
    dds_rhc head;  ///< must be first: Cyclone passes its address
    dds_rhc* store;
    InstanceQuota* quota;
  };

 private:
  Face face_;
};

}  // namespace rubicon::tuples::dds
