#include "base/virtual_scheduler.h"

#include <algorithm>
#include <utility>

namespace rubicon::base {

Timer& Timer::operator=(Timer&& other) noexcept {
  if (this != &other) {
    cancel();
    entry_ = std::move(other.entry_);
  }
  return *this;
}

void Timer::cancel() {
  // The call may own this timer: release everything before it is destroyed.
  const auto entry = std::exchange(entry_, nullptr);
  if (entry) const auto call = std::exchange(entry->call, nullptr);
}

bool TimerHeap::later(const Slot& a, const Slot& b) {
  return a.when != b.when ? a.when > b.when : a.age > b.age;
}

Timer TimerHeap::add(SteadyTime when, std::function<void()> call) {
  if (heap_.size() >= sweep_at_) sweep();
  auto entry = std::make_shared<Timer::Entry>(Timer::Entry{std::move(call)});
  heap_.push_back({when, ages_++, entry});
  std::push_heap(heap_.begin(), heap_.end(), later);
  return Timer(std::move(entry));
}

void TimerHeap::sweep() {
  std::erase_if(heap_, [](const Slot& slot) { return !slot.entry->call; });
  std::make_heap(heap_.begin(), heap_.end(), later);
  sweep_at_ = std::max<std::size_t>(1024, heap_.size() * 2);
}

void TimerHeap::drop_cancelled_front() {
  while (!heap_.empty() && !heap_.front().entry->call) {
    std::pop_heap(heap_.begin(), heap_.end(), later);
    heap_.pop_back();
  }
}

std::optional<SteadyTime> TimerHeap::next() {
  drop_cancelled_front();
  if (heap_.empty()) return std::nullopt;
  return heap_.front().when;
}

std::function<void()> TimerHeap::take_due(SteadyTime now) {
  const auto due = next();
  if (!due || *due > now) return nullptr;
  std::pop_heap(heap_.begin(), heap_.end(), later);
  auto entry = std::move(heap_.back().entry);
  heap_.pop_back();
  return std::exchange(entry->call, nullptr);
}

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
