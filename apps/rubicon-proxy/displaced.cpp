#include "apps/rubicon-proxy/displaced.h"

#include <fmt/format.h>

#include "base/printable.h"
#include "rubicon/summary.hpp"
#include "transport/host_name.h"

namespace rubicon::daemon {

namespace {

/// Of the consoles on that host the one of this island, which has the same last seven bits (daemon.cpp); not our own.
std::string process_of(OwnerId island, const std::string& host,
                       const std::vector<tuples::dds::ComponentStart>& starts) {
  constexpr std::uint32_t kIslands = 128;
  for (const auto& one : starts) {
    const auto summary = model::summary_from_json(one.summary);
    const bool fits = one.present && number(one.id) % kIslands == number(island) % kIslands;
    if (!fits || !summary || summary->name != kConsole || summary->host != host) continue;
    if (summary->program != transport::own_process()) return summary->program;
  }
  return {};
}

/// `, pid 4711 of anna on attic`; empty where the summary of the component does not say.
std::string holder_of(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts) {
  for (const auto& one : starts) {
    if (one.id != id || !one.present) continue;
    const auto summary = model::summary_from_json(one.summary);
    if (!summary || summary->program.empty()) continue;
    const auto process = process_of(id, summary->host, starts);
    return base::printable(fmt::format(", {} on {}", process.empty() ? summary->program : process, summary->host));
  }
  return {};
}

}  // namespace

std::string way_out(OwnerId id) {
  if (number(id) > model::kMaxIslandId) return {};
  return fmt::format(": stop that one, or give this island another id (`island.id`, or --set island.id={})",
                     number(id) % model::kMaxIslandId + 1);
}

std::string in_use_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts) {
  return fmt::format("component id {} is in use by another process{}", number(id), holder_of(id, starts));
}

std::string displaced_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts) {
  return in_use_text(id, starts) + way_out(id) + "; exiting";
}

}  // namespace rubicon::daemon
