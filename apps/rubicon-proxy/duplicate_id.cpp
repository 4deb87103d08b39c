#include "apps/rubicon-proxy/duplicate_id.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>

#include "base/text.h"
#include "rubicon/summary.hpp"
#include "transport/host_names.h"

namespace rubicon::daemon {

namespace {

/// The console of this island on that host. Its id has the same last seven bits (daemon.cpp). It is not our own
/// console.
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

namespace {

using namespace std::chrono_literals;

constexpr Duration kStep = 20ms;
/// How long others may take to show themselves by DDS, how long while some were found, and how long in a PEIS network,
/// where each host announces itself once a second.
constexpr Duration kSearch = 500ms, kHandshake = 2s, kAnnouncements = 1500ms;
/// A lease ends a little later than its time.
constexpr Duration kGrace = 500ms;

void run_for_a_step(transport::Loop& loop) {
  bool over = false;
  const auto step = loop.scheduler().after(kStep, [&over] { over = true; });
  while (!over && loop.context().run_one() > 0) continue;  // none runs once the loop is stopped
}

Duration search_time(const tuples::engines::Engines& engines) {
  Duration least{0};
  if (engines.peis()) least = kAnnouncements;
  if (const auto* dds = engines.dds()) least = std::max(least, dds->expects_components() ? kHandshake : kSearch);
  return least;
}

bool is_there(const tuples::engines::Engines& engines, const TupleSpace& listener, OwnerId id) {
  const auto peers = listener.peers();
  if (std::find(peers.begin(), peers.end(), id) != peers.end()) return true;
  if (!engines.dds()) return false;
  const auto starts = engines.dds()->component_starts();  // those that are ignored, too
  return std::any_of(starts.begin(), starts.end(), [id](const auto& one) { return one.id == id && one.present; });
}

}  // namespace

/// Counts steps and not time: a process that was stopped has heard nothing meanwhile.
Result<void> await_alone(transport::Loop& loop, const tuples::engines::Engines& engines, const TupleSpace& listener,
                         OwnerId id, Duration lease, const std::function<bool()>& given_up) {
  if (!engines.dds() && !engines.peis()) return {};
  Duration searched{0}, seen{0};
  while (true) {
    run_for_a_step(loop);
    if (given_up() || loop.context().stopped()) return fail(ErrorCode::kIo, "ended before the island was up");
    searched += kStep;
    const bool found = is_there(engines, listener, id);
    seen = found ? seen + kStep : Duration(0);
    if (seen > lease + kGrace)
      return fail(ErrorCode::kDuplicate, in_use_text(id, engines.dds() ? engines.dds()->component_starts()
                                                                       : std::vector<tuples::dds::ComponentStart>()));
    if (!found && searched > search_time(engines)) return {};
  }
}

}  // namespace rubicon::daemon
