#include "tuples/engines/engines.h"

#include <utility>
#include <vector>

#include "transport/host_name.h"
#include "tuples/joined/joined_ecology.h"

namespace rubicon::tuples::engines {

Result<std::unique_ptr<Engines>> Engines::open(const EngineOptions& options, const Host& host) {
  if (!options.dds && !options.peis) return fail(ErrorCode::kInvalid, "no engine, expected dds, peis or both");
  auto engines = std::unique_ptr<Engines>(new Engines());
  if (options.dds) {
    auto dds = dds::DdsEcology::open(*options.dds, host.scheduler, host.post, host.log);
    if (!dds) return fail(dds.error());
    engines->dds_ = std::move(*dds);
    engines->all_ = engines->dds_.get();
  }
  if (!options.peis) return engines;
  auto peis = peis::PeisEcology::open(*options.peis, host.scheduler, host.transports, host.log);
  if (!peis) return fail(peis.error());
  engines->peis_ = std::move(*peis);
  engines->all_ = engines->peis_.get();
  if (engines->dds_) {
    engines->join_both(options, host);
  } else if (options.peis->judge) {
    engines->join_own_process(host);
  }
  return engines;
}

/// PEIS cannot prove which components are of this process, so these meet in memory, where they may do everything. What
/// comes by PEIS in the name of one of them is judged as all that comes by PEIS.
void Engines::join_own_process(const Host& host) {
  own_process_ = std::make_unique<MemoryEcology>(host.scheduler, transport::host_id("host"));
  joined_ = std::make_unique<joined::JoinedEcology>(
      std::vector<joined::JoinedEcology::Engine>{{"memory", *own_process_}, {"peis", *peis_}}, host.scheduler,
      host.log);
  all_ = joined_.get();
}

Result<bool> Engines::renew() {
  return dds_ ? dds_->renew() : false;
}

void Engines::join_both(const EngineOptions& options, const Host& host) {
  if (!options.carry.empty()) {
    using Engine = carry::Carrier::Engine;
    carrier_ = std::make_unique<carry::Carrier>(options.carrier, options.carry,
                                                std::array{Engine{"dds", *dds_}, Engine{"peis", *peis_}},
                                                host.scheduler, host.log);
  }
  Ecology& dds = carrier_ ? carrier_->engine(0) : *dds_;
  Ecology& peis = carrier_ ? carrier_->engine(1) : *peis_;
  joined_ = std::make_unique<joined::JoinedEcology>(
      std::vector<joined::JoinedEcology::Engine>{{"dds", dds}, {"peis", peis}}, host.scheduler, host.log);
  all_ = joined_.get();
}

void Engines::watch_displaced(const std::function<void(OwnerId)>& call) {
  if (dds_) dds_->watch_displaced(call);
  if (peis_) peis_->watch_displaced(call);
}

}  // namespace rubicon::tuples::engines
