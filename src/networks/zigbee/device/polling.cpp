#include "networks/zigbee/device/polling.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::zigbee::device {

Polling::Polling(Scheduler& scheduler, Duration retry, Ask ask)
    : scheduler_(scheduler), retry_(retry), ask_(std::move(ask)), deadline_(scheduler, [this] { step(); }) {}

void Polling::once(const std::vector<std::size_t>& properties) {
  once_.insert(properties.begin(), properties.end());
  schedule();
}

void Polling::demand(std::vector<std::size_t> properties, Duration period) {
  demanded_ = std::move(properties);
  period_ = std::max(period, kShortest);
  const bool polls = period > Duration(0) && !demanded_.empty();
  next_poll_ = polls ? scheduler_.now() + period_ : SteadyTime::max();
  schedule();
}

void Polling::clear() {
  once_.clear();
  demand({}, Duration(0));
}

void Polling::line(bool up) {
  up_ = up;
  if (!up) once_.clear();
  schedule();
}

void Polling::step() {
  const auto now = scheduler_.now();
  auto wanted = once_;
  if (next_poll_ <= now) wanted.insert(demanded_.begin(), demanded_.end());
  if (!up_ || wanted.empty()) return schedule();
  if (!ask_({wanted.begin(), wanted.end()})) {
    not_before_ = now + retry_;
    return schedule();
  }
  once_.clear();
  not_before_ = now + kShortest;
  if (next_poll_ <= now) next_poll_ = now + period_;
  schedule();
}

void Polling::schedule() {
  auto next = once_.empty() ? next_poll_ : scheduler_.now();
  if (!up_) next = SteadyTime::max();
  if (next != SteadyTime::max()) next = std::max(next, not_before_);
  deadline_.set_at(next);
}

}  // namespace rubicon::networks::zigbee::device
