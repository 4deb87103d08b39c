#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tuples/carry/carrier.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/host/folder.h"
#include "tuples/host/host_ecology.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::engines {

/// Where the processes of this host meet.
struct HostSetup {
  host::Place place;
  std::string space = host::kDefaultSpace;
  host::HostOptions options;
};

/// The engines of a process, at least one, and how each finds other components.
struct EngineOptions {
  std::optional<HostSetup> host;
  std::optional<dds::DdsOptions> dds;
  std::optional<mqtt::SpaceOptions> mqtt;
  std::optional<peis::PeisOptions> peis;
  carry::CarryRules carry;            ///< between them, by the names host, dds, mqtt, peis
  OwnerId carrier = model::kNoOwner;  ///< the component that carries, if anything is
};

/// The engines of a process as one ecology: each of its components takes part on all of them. If there are several, the
/// order for decision 022 is host, dds, mqtt, peis.
class Engines final : public Ecology {
 public:
  /// What the engines use; it outlives them.
  struct Host {
    Scheduler& scheduler;
    dds::DdsEcology::Post post;
    transport::Transports& transports;
    base::LogSink& log;
    transport::WatchInterfaces watch_interfaces;
  };
  /// As open_disk_folder(), DdsEcology::open(), MqttEcology::open() and PeisEcology::open(). kInvalid: no engine.
  static Result<std::unique_ptr<Engines>> open(const EngineOptions& options, const Host& host);

  Result<std::unique_ptr<Link>> join(OwnerId id) override { return all_->join(id); }
  /// HostEcology::check_free(). Without the engine host this is not known at once.
  Result<void> check_free(OwnerId id) { return host_ ? host_->check_free(id) : Result<void>(); }
  /// As the engines do: `call` receives the component of this process whose id another component used before.
  void watch_displaced(const std::function<void(OwnerId)>& call);

  /// Null: not among them.
  const host::HostEcology* host() const { return host_.get(); }
  const dds::DdsEcology* dds() const { return dds_.get(); }
  mqtt::MqttEcology* mqtt() const { return mqtt_.get(); }
  const peis::PeisEcology* peis() const { return peis_.get(); }

 private:
  Engines() = default;
  Result<void> open_host(const HostSetup& setup, const Host& host);
  Result<void> open_distant(const EngineOptions& options, const Host& host);
  void join_all(const EngineOptions& options, const Host& host);

  std::unique_ptr<host::HostEcology> host_;
  std::unique_ptr<dds::DdsEcology> dds_;
  std::unique_ptr<mqtt::MqttEcology> mqtt_;
  std::unique_ptr<peis::PeisEcology> peis_;
  std::unique_ptr<MemoryEcology> own_process_;  ///< null: the engines know which components are of this process
  std::unique_ptr<carry::Carrier> carrier_;     ///< null: nothing is carried
  std::unique_ptr<Ecology> joined_;             ///< of several
  Ecology* all_ = nullptr;
};

}  // namespace rubicon::tuples::engines
