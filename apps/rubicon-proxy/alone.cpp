#include "apps/rubicon-proxy/alone.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>

#include "apps/rubicon-proxy/displaced.h"

namespace rubicon::daemon {

namespace {

using namespace std::chrono_literals;

constexpr Duration kStep = 20ms;
/// How long others may take to show themselves, and how long while some were found.
constexpr Duration kSearch = 500ms, kHandshake = 2s;
/// A lease ends a little later than its time.
constexpr Duration kGrace = 500ms;

void run_for_a_step(transport::Loop& loop) {
  bool over = false;
  const auto step = loop.scheduler().after(kStep, [&over] { over = true; });
  while (!over && loop.context().run_one() > 0) continue;  // none runs once the loop is stopped
}

}  // namespace

/// Counts steps and not time: a process that was stopped has heard nothing meanwhile.
Result<void> await_alone(transport::Loop& loop, const tuples::dds::DdsEcology& dds, OwnerId id, Duration lease,
                         const std::function<bool()>& given_up) {
  Duration searched{0}, seen{0};
  while (true) {
    run_for_a_step(loop);
    if (given_up() || loop.context().stopped()) return fail(ErrorCode::kIo, "ended before the island was up");
    searched += kStep;
    const auto starts = dds.component_starts();
    const bool is_there =
        std::any_of(starts.begin(), starts.end(), [id](const auto& one) { return one.id == id && one.present; });
    seen = is_there ? seen + kStep : Duration(0);
    if (seen > lease + kGrace) return fail(ErrorCode::kDuplicate, in_use_text(id, starts));
    if (!is_there && searched > (dds.expects_components() ? kHandshake : kSearch)) return {};
  }
}

}  // namespace rubicon::daemon
