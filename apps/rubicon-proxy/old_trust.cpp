#include "apps/rubicon-proxy/old_trust.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>

namespace rubicon::daemon {

namespace {

using config::OldTrust;

constexpr const char* kOldTraces[] = {"/etc/rubicon/trust", "/etc/rubicon/trust.realm"};

/// Empty: nothing shows that there were certificates. What cannot be seen counts.
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
            "trust: this release has no certificates for DDS, and the island is not on DDS: leave it out"};
  return {};
}

}  // namespace rubicon::daemon
