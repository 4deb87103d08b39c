#pragma once

#include <functional>
#include <map>
#include <vector>

#include "base/scheduler.h"
#include "tuples/peis/discovery.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/routes.h"

namespace rubicon::tuples::peis {

/// Where kernels run: one that says it is on this host shows it by a connection, and rights depend on it. Holds its
/// requests until it did, or had the time to do so. Bounded.
class Places {
 public:
  /// `take` receives what was held, in order. All must outlive it.
  Places(NodeContext& context, const Hosts& hosts, const Routes& routes, const NodeLinks& links, Dialer& dialer,
         std::function<void(const Package&)> take);

  /// Whether a kernel claims to be on this host without proof, because its packages come through others.
  bool is_unknown(OwnerId kernel) const;
  /// A request that must not be judged before. The package is not acknowledged, so that the kernel sends it again if it
  /// is lost here.
  void hold(const Package& package);
  bool holds_of(OwnerId kernel) const;
  /// Passes on the requests of those whose place is known by now, or was not shown in time.
  void release();
  /// The host connected.
  void met(OwnerId host) {
    if (waiting_.contains(host)) release();
  }

 private:
  struct Held {
    PackageHeader header;
    Bytes body;
  };

  NodeContext& context_;
  const Hosts& hosts_;
  const Routes& routes_;
  const NodeLinks& links_;
  Dialer& dialer_;
  std::function<void(const Package&)> take_;
  std::vector<Held> held_;                 ///< requests of `waiting_`, in order
  std::map<OwnerId, SteadyTime> waiting_;  ///< kernels that say they are here, and since when that is unknown
  base::Deadline due_;
};

}  // namespace rubicon::tuples::peis
