#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "transport/transports.h"
#include "tuples/peis/peis_options.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples::peis {

class Presence;

/// The components of a PEIS network, of ours and of the PEIS kernels of 2013. Each component of this process is a node
/// of its own. It outlives its links.
class PeisEcology final : public StandInEcology {
 public:
  /// As select_interfaces(). The scheduler, the transports and the log outlive it.
  static Result<std::unique_ptr<PeisEcology>> open(PeisOptions options, Scheduler& scheduler,
                                                   transport::Transports& transports, base::LogSink& log,
                                                   PeisMachine machine = PeisMachine::own());
  ~PeisEcology() override;

  /// The component is seen by others from the link's attach() on. kOutOfRange: the id is not 1 to 2^31-1; kernels close
  /// connections with other ids, and do not acknowledge to 0.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  /// On any free port, connected with the first port of the options: kernels find it by way of the others.
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// `call` receives, in a later turn, the component of this process whose id another live component uses and used
  /// before. That component should end.
  void watch_displaced(std::function<void(OwnerId)> call);

  /// The nodes of this process that are present, for diagnosis.
  std::vector<const Presence*> presences() const;

 private:
  struct Impl;
  explicit PeisEcology(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::peis
