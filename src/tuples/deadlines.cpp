#include "tuples/deadlines.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace rubicon::tuples {

namespace {

constexpr std::size_t kMaxPerRun = 10'000;

bool later(const Deadline& a, const Deadline& b) {
  return a.when > b.when;
}

std::optional<double> number_in(std::string_view text) {
  const auto value = base::parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

Deadlines::Deadlines(Scheduler& scheduler, Call call, StillMatters still_matters)
    : scheduler_(scheduler), call_(std::move(call)), still_matters_(std::move(still_matters)) {}

void Deadlines::add(const Deadline& deadline) {
  if (heap_.size() >= sweep_at_) sweep();
  heap_.push_back(deadline);
  std::push_heap(heap_.begin(), heap_.end(), later);
  if (deadline.when < armed_) arm();
}

void Deadlines::arm() {
  armed_ = heap_.empty() ? SteadyTime::max() : heap_.front().when;
  if (heap_.empty()) return;
  timer_ = scheduler_.at(armed_, [this] { run(); });
}

void Deadlines::run() {
  const auto now = scheduler_.now();
  armed_ = SteadyTime::min();  // so that add() does not arm the timer meanwhile
  for (std::size_t count = 0; count < kMaxPerRun && !heap_.empty() && heap_.front().when <= now; ++count) {
    const auto deadline = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), later);
    heap_.pop_back();
    call_(deadline, now);
  }
  arm();
}

void Deadlines::sweep() {
  std::erase_if(heap_, [this](const Deadline& deadline) { return !still_matters_(deadline); });
  std::make_heap(heap_.begin(), heap_.end(), later);
  sweep_at_ = std::max<std::size_t>(1024, heap_.size() * 2);
  if (heap_.capacity() > 4 * sweep_at_) heap_.shrink_to_fit();
}

void Expiry::set(std::uint32_t index, Duration lifetime, SteadyTime now) {
  auto& times = times_[index];
  times.ends = now + std::min(lifetime, kMaxDuration);
  if (times.ends < times.armed) arm(index, times);
}

void Expiry::arm(std::uint32_t index, Times& times) {
  times.armed = times.ends;
  deadlines_.add({times.ends, 0, index, store_.at(index).generation});
}

bool Expiry::is_armed(const Deadline& deadline) const {
  const auto found = times_.find(deadline.tuple);
  return found != times_.end() && found->second.armed == deadline.when;
}

bool Expiry::is_due(std::uint32_t index, SteadyTime now) {
  const auto found = times_.find(index);
  if (found == times_.end()) return false;
  auto& times = found->second;
  if (times.ends <= now) return true;
  if (times.armed <= now) arm(index, times);
  return false;
}

bool Pacer::offer(Subscription& subscription, std::uint32_t index, SteadyTime now) {
  const auto [found, fresh] = subscription.paces.try_emplace(index);
  auto& pace = found->second;
  if (!fresh) {
    if (now - pace.last < subscription.flow.minimum) {
      pace.pending = true;
      arm(subscription, pace, index);
      return false;
    }
    if (within_dead_band(subscription, pace, index)) return false;
  }
  delivered(subscription, pace, index, now);
  return true;
}

void Pacer::begin(Subscription& subscription, std::uint32_t index, SteadyTime now) {
  delivered(subscription, subscription.paces[index], index, now);
}

bool Pacer::is_armed(const Subscription& subscription, const Deadline& deadline) {
  const auto found = subscription.paces.find(deadline.tuple);
  return found != subscription.paces.end() && found->second.armed == deadline.when;
}

Pacer::Due Pacer::due(Subscription& subscription, std::uint32_t index, SteadyTime now) {
  const auto found = subscription.paces.find(index);
  if (found == subscription.paces.end()) return Due::kNothing;
  auto& pace = found->second;
  if (pace.armed <= now) pace.armed = SteadyTime::max();
  const auto& flow = subscription.flow;
  if (pace.pending && now - pace.last >= flow.minimum) {
    pace.pending = false;
    if (!within_dead_band(subscription, pace, index)) {
      delivered(subscription, pace, index, now);
      return Due::kChange;
    }
  }
  if (flow.maximum > Duration(0) && now - pace.last >= std::max(flow.maximum, flow.minimum)) {
    delivered(subscription, pace, index, now);
    return Due::kHeartbeat;
  }
  arm(subscription, pace, index);
  return Due::kNothing;
}

bool Pacer::within_dead_band(const Subscription& subscription, const Pace& pace, std::uint32_t index) const {
  if (!(subscription.flow.dead_band > 0) || !pace.has_number) return false;
  const auto number = number_in(store_.at(index).value);
  return number && std::abs(*number - pace.number) < subscription.flow.dead_band;
}

void Pacer::delivered(Subscription& subscription, Pace& pace, std::uint32_t index, SteadyTime now) {
  pace.last = now;
  pace.pending = false;
  if (subscription.flow.dead_band > 0) {
    const auto number = number_in(store_.at(index).value);
    pace.has_number = number.has_value();
    pace.number = number.value_or(0);
  }
  arm(subscription, pace, index);
}

void Pacer::arm(const Subscription& subscription, Pace& pace, std::uint32_t index) {
  const auto& flow = subscription.flow;
  auto next = SteadyTime::max();
  if (pace.pending) next = pace.last + flow.minimum;
  if (subscription.local() && flow.maximum > Duration(0)) {
    next = std::min(next, pace.last + std::max(flow.maximum, flow.minimum));
  }
  if (next >= pace.armed) return;
  pace.armed = next;
  deadlines_.add({next, subscription.number, index, store_.at(index).generation});
}

}  // namespace rubicon::tuples
