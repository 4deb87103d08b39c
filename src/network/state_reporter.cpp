#include "network/state_reporter.h"

#include <utility>

namespace rubicon::network {

void StateReporter::line_changed() {
  pending_.cancel();
  if (auto state = state_()) host_.deliver({}, std::move(*state));
}

void StateReporter::counters_changed() {
  if (pending_.pending()) return;
  pending_ = host_.scheduler().after(period_, [this] { line_changed(); });
}

}  // namespace rubicon::network
