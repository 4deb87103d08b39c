#include "web/paced_updates.h"

namespace rubicon::bench::web {

using namespace std::chrono_literals;

void PacedUpdates::set_rate(int rate) {
  rate_ = rate;
  made_before_ = made_;
  began_ = Clock::now();
  next_ = {};
  if (rate > 0) tick();
}

void PacedUpdates::tick() {
  const auto due = made_before_ + static_cast<std::uint64_t>(seconds_since(began_) * rate_);
  while (made_ < due) call_(++made_);
  next_ = scheduler_.after(5ms, [this] { tick(); });
}

}  // namespace rubicon::bench::web
