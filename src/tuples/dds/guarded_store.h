#pragma once

#include <dds/dds.h>
#include <dds/ddsc/dds_rhc.h>

#include "tuples/dds/entity.h"
#include "tuples/dds/identities.h"
#include "tuples/dds/instance_quota.h"

namespace rubicon::tuples::dds {

/// Wraps the store of a reader (Cyclone: reader history cache) and drops samples beyond the quota, and those that claim
/// an id that their writer may not use: they change no instance that others see. A topic filter is not enough: Cyclone
/// applies it to values only, and keeps an instance for each dispose. Outlives its reader. The first field of the type
/// is its key, and the id.
class GuardedStore {
 public:
  /// Null claims: no sample is checked.
  explicit GuardedStore(InstanceQuota& quota, Claims* claims = nullptr);
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
    Claims* claims;
  };

 private:
  Face face_;
};

}  // namespace rubicon::tuples::dds
