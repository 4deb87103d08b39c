#include "apps/rubicon-proxy/alone.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>

#include "apps/rubicon-proxy/displaced.h"

namespace rubicon::daemon {

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
