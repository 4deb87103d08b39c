#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/link.h"

namespace rubicon::tuples::joined {

/// Several engines as one ecology (docs/decisions/022-two-engines.md). Own tuples are offered on all of them; another
/// component lives on the first engine, in their order, of those on which it was met. The engines outlive it.
class JoinedEcology final : public Ecology {
 public:
  struct Engine {
    std::string name;  ///< as in the configuration: `dds`, `peis`
    Ecology& ecology;
  };

  /// At least one engine, at most kMaxEngines. `own_host`: PeerIdentity::host of this one, if its components have a
  /// proof of that, engine `host`: what DDS brings in its name is ignored then.
  JoinedEcology(std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log, std::string own_host = {});

  static constexpr std::size_t kMaxEngines = 8;

  /// The error of the first engine that cannot make the link, with the engine's name.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;

 private:
  std::vector<Engine> engines_;
  std::string own_host_;
  Scheduler& scheduler_;
  base::LogSink& log_;
};

}  // namespace rubicon::tuples::joined
