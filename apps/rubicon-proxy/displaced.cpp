#include "apps/rubicon-proxy/displaced.h"

#include <fmt/format.h>

#include "base/printable.h"
#include "rubicon/summary.hpp"

namespace rubicon::daemon {

namespace {

/// `, rubicon-proxy (pid 4711 of anna) on attic`; empty where its summary does not say.
std::string holder_of(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts) {
  for (const auto& one : starts) {
    if (one.id != id || !one.present) continue;
    const auto summary = model::summary_from_json(one.summary);
    if (!summary || summary->program.empty()) continue;
    return base::printable(fmt::format(", {} on {}", summary->program, summary->host));
  }
  return {};
}

}  // namespace

std::string displaced_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts) {
  const auto next = number(id) % model::kMaxIslandId + 1;
  const auto way_out =
      number(id) <= model::kMaxIslandId
          ? fmt::format(": stop that one, or give this island another id (`island.id`, or --set island.id={})", next)
          : std::string();
  return fmt::format("component id {} is in use by another process{}{}; exiting", number(id), holder_of(id, starts),
                     way_out);
}

}  // namespace rubicon::daemon
