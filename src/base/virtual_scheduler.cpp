#include "base/virtual_scheduler.h"

namespace rubicon::base {

using namespace std::chrono_literals;

VirtualScheduler::VirtualScheduler()
    : now_(SteadyTime(1h)), wall_(std::chrono::sys_days(std::chrono::year(2026) / 1 / 1)) {}

void VirtualScheduler::run_posted() {
  while (!posted_.empty()) {
    auto call = std::move(posted_.front());
    posted_.pop_front();
    call();
  }
}

void VirtualScheduler::run_ready() {
  do {
    run_posted();
    while (auto call = timers_.take_due(now_)) {
      call();
      run_posted();
    }
  } while (outside_ && outside_());
}

void VirtualScheduler::advance_to(SteadyTime when) {
  wall_rest_ += when - now_;
  const auto whole = std::chrono::floor<std::chrono::microseconds>(wall_rest_);
  wall_ += whole;
  wall_rest_ -= whole;
  now_ = when;
}

void VirtualScheduler::run_for(Duration span) {
  const SteadyTime end = now_ + span;
  run_ready();
  for (auto next = timers_.next(); next && *next <= end; next = timers_.next()) {
    if (*next > now_) advance_to(*next);
    run_ready();
  }
  advance_to(end);
  run_ready();
}

}  // namespace rubicon::base
