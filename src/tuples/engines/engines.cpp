#include "tuples/engines/engines.h"

#include <utility>
#include <vector>

#include "transport/host_names.h"
#include "tuples/host/folder.h"
#include "tuples/joined/joined_ecology.h"

namespace rubicon::tuples::engines {

Result<std::unique_ptr<Engines>> Engines::open(const EngineOptions& options, const Host& host) {
  if (!options.host && !options.dds && !options.mqtt && !options.peis)
    return fail(ErrorCode::kInvalid, "no engine, expected one or more of host, dds, mqtt and peis");
  std::unique_ptr<Engines> engines(new Engines());
  if (options.host) {
    if (auto opened = engines->open_host(*options.host, host); !opened) return fail(std::move(opened.error()));
  }
  if (auto opened = engines->open_distant(options, host); !opened) return fail(std::move(opened.error()));
  engines->join_all(options, host);
  return engines;
}

Result<void> Engines::open_host(const HostSetup& setup, const Host& host) {
  auto folder = host::open_disk_folder(setup.place, setup.space, host.scheduler, host.transports);
  if (!folder) return fail(std::move(folder.error()));
  auto opened = host::HostEcology::open(std::move(*folder), setup.options, host.scheduler, host.log);
  if (!opened) return fail(std::move(opened.error()));
  host_ = std::move(*opened);
  return {};
}

Result<void> Engines::open_distant(const EngineOptions& options, const Host& host) {
  if (options.dds) {
    auto opened = dds::DdsEcology::open(*options.dds, host.scheduler, host.post, host.log);
    if (!opened) return fail(std::move(opened.error()));
    dds_ = std::move(*opened);
    dds_->follow(host.watch_interfaces);
  }
  if (options.mqtt) {
    auto opened = mqtt::MqttEcology::open(*options.mqtt, host.scheduler, host.transports, host.log);
    if (!opened) return fail(std::move(opened.error()));
    mqtt_ = std::move(*opened);
  }
  if (!options.peis) return {};
  auto opened = peis::PeisEcology::open(*options.peis, host.scheduler, host.transports, host.log);
  if (!opened) return fail(std::move(opened.error()));
  peis_ = std::move(*opened);
  return {};
}

/// PEIS cannot prove which components are of this process. Without an engine that does, these meet in memory, where
/// they may do everything. A request by PEIS in the name of one of them is judged like every request by PEIS.
void Engines::join_all(const EngineOptions& options, const Host& host) {
  std::vector<carry::Carrier::Engine> open;
  if (host_) open.push_back({"host", *host_});
  if (dds_) open.push_back({"dds", *dds_});
  if (mqtt_) open.push_back({"mqtt", *mqtt_});
  if (peis_) open.push_back({"peis", *peis_});
  std::vector<joined::JoinedEcology::Engine> all;
  if (open.size() == 1 && peis_ && options.peis->judge) {
    own_process_ = std::make_unique<MemoryEcology>(host.scheduler, transport::host_id("host"));
    all.push_back({"memory", *own_process_});
  }
  if (!options.carry.empty() && open.size() > 1) {
    carrier_ = std::make_unique<carry::Carrier>(options.carrier, options.carry, open, host.scheduler, host.log);
    if (mqtt_) mqtt_->seeks(std::nullopt);  // who is to be carried may be anybody
  }
  for (std::size_t i = 0; i < open.size(); ++i)
    all.push_back({open[i].name, carrier_ ? carrier_->engine(i) : open[i].ecology});
  all_ = &all.front().ecology;
  if (all.size() == 1) return;
  joined_ = std::make_unique<joined::JoinedEcology>(std::move(all), host.scheduler, host.log,
                                                    host_ ? transport::host_id("host") : std::string());
  all_ = joined_.get();
}

void Engines::watch_displaced(const std::function<void(OwnerId)>& call) {
  if (host_) host_->watch_displaced(call);
  if (dds_) dds_->watch_displaced(call);
  if (mqtt_) mqtt_->watch_displaced(call);
  if (peis_) peis_->watch_displaced(call);
}

}  // namespace rubicon::tuples::engines
