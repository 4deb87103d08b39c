#include "apps/rubicon-proxy/engine_setup.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>

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
  if (config.rights) return engine.dds ? "rights decide; all that come by DDS are the member lan" : "";
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

namespace {

using config::OldTrust;

constexpr const char* kOldTraces[] = {"/etc/rubicon/trust", "/etc/rubicon/trust.realm"};

/// Empty: nothing shows that there were certificates. A path that this user may not read counts as a sign.
std::string trace_of_certificates(const config::EngineSetup& engine) {
  if (engine.old_trust == OldTrust::kYes) return "tuples.trust";
  const char* variable = std::getenv("RUBICON_TRUST");
  const std::string_view asked = variable == nullptr ? "" : variable;
  if (asked == "no") return {};
  if (!asked.empty()) return "RUBICON_TRUST";
  for (const auto* path : kOldTraces) {
    struct stat about {};
    if (::lstat(path, &about) == 0 || errno != ENOENT) return path;
  }
  return {};
}

}  // namespace

void hold_back_dds(config::EngineSetup& engine) {
  if (!engine.dds || engine.old_trust == OldTrust::kNo) return;
  engine.held_back = trace_of_certificates(engine);
  engine.dds = engine.held_back.empty();
}

std::vector<std::string> held_back_lines(const config::EngineSetup& engine) {
  if (!engine.held_back.empty())
    return {
        fmt::format("{}: this island had certificates for DDS, which this release does not have: it does not take "
                    "part by DDS",
                    engine.held_back),
        "choose: a broker with a realm (docs/sites.md), or `tuples: {trust: no}` on a network whose machines are all "
        "trusted (docs/trust.md)"};
  if (engine.old_trust == OldTrust::kYes)
    return {engine.place +
            "trust: this release has no certificates for DDS, and the island is not on DDS: remove this key"};
  return {};
}

}  // namespace rubicon::daemon
