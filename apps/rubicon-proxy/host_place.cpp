#include "apps/rubicon-proxy/host_place.h"

#include <fmt/format.h>

namespace rubicon::daemon {

Result<tuples::engines::HostSetup> host_setup(const config::EngineSetup& engine) {
  auto place = tuples::host::choose_place(engine.folder, tuples::host::Surroundings::of_process());
  if (!place) return fail(std::move(place.error()));
  return tuples::engines::HostSetup{
      std::move(*place), tuples::host::choose_space(engine.space), {.lease = engine.options.lease}};
}

bool is_closed(const island::IslandConfig& config) {
  const auto host = config.engine.host ? host_setup(config.engine) : fail(ErrorCode::kNotFound, "");
  const bool had_certificates = config.engine.old_trust == config::OldTrust::kYes || !config.engine.held_back.empty();
  return config.rights || had_certificates || (host && host->place.shared);
}

std::string who_may_command(const island::IslandConfig& config) {
  const auto& engine = config.engine;
  if (config.rights) return engine.dds ? "rights decide; whoever comes by DDS is the member lan" : "";
  const bool leaves_host = engine.dds && !tuples::dds::is_loopback_only(engine.options);
  if ((leaves_host && engine.options.trust_lan) || (engine.peis && engine.peis_options.trust_lan))
    return "anybody who reaches its interfaces may command it";
  if (engine.mqtt && engine.mqtt_space.trust_broker && engine.mqtt_space.realm_folder().empty())
    return "without a realm: anybody at its broker may command it";
  if (leaves_host) return "anybody who reaches its interfaces may read it, anybody on this host may command it";
  if (engine.dds || engine.peis) return "anybody on this host may command it";
  const auto host = engine.host ? host_setup(engine) : fail(ErrorCode::kNotFound, "");
  return host ? fmt::format("whoever may enter {} may command it", host->place.path) : std::string();
}

}  // namespace rubicon::daemon
