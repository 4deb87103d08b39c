#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "tuples/carry/carrier.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::engines {

/// The engines of a process, at least one, and how each finds other components.
struct EngineOptions {
  std::optional<dds::DdsOptions> dds;
  std::optional<peis::PeisOptions> peis;
  carry::CarryRules carry;            ///< between both
  OwnerId carrier = model::kNoOwner;  ///< the component that carries, if anything is
};

/// The engines of a process as one ecology: each of its components takes part on all of them. If there are several, the
/// order for decision 022 is dds, peis.
class Engines final : public Ecology {
 public:
  /// What the engines use; it outlives them.
  struct Host {
    Scheduler& scheduler;
    dds::DdsEcology::Post post;
    transport::Transports& transports;
    base::LogSink& log;
  };
  /// As DdsEcology::open() and PeisEcology::open(). kInvalid: no engine.
  static Result<std::unique_ptr<Engines>> open(const EngineOptions& options, const Host& host);

  Result<std::unique_ptr<Link>> join(OwnerId id) override { return all_->join(id); }
  /// What changed in the trust folder counts from now on: DdsEcology::renew(). Nothing without DDS or without trust.
  Result<bool> renew();
  /// As those of the engines: `call` receives the component of this process whose id another component used before.
  void watch_displaced(const std::function<void(OwnerId)>& call);

  /// Null: not among them.
  const dds::DdsEcology* dds() const { return dds_.get(); }
  const peis::PeisEcology* peis() const { return peis_.get(); }

 private:
  Engines() = default;
  void join_both(const EngineOptions& options, const Host& host);
  void join_own_process(const Host& host);

  std::unique_ptr<dds::DdsEcology> dds_;
  std::unique_ptr<peis::PeisEcology> peis_;
  std::unique_ptr<MemoryEcology> own_process_;  ///< null: the engines know which components are of this process
  std::unique_ptr<carry::Carrier> carrier_;     ///< null: nothing is carried
  std::unique_ptr<Ecology> joined_;             ///< of several
  Ecology* all_ = nullptr;
};

}  // namespace rubicon::tuples::engines
