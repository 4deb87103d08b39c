#include "networks/zigbee/poll_places.h"

namespace rubicon::networks::zigbee {

bool PollPlaces::take(const std::string& device) {
  const auto now = scheduler_.now();
  if (now - second_ >= std::chrono::seconds(1)) {
    second_ = now;
    taken_ = 0;
  }
  if (!has_place(device)) {
    wait(device);
    return false;
  }
  ++taken_;
  if (const auto found = by_device_.find(device); found != by_device_.end()) remove(found->second);
  return true;
}

/// The free places belong to the first in the line.
bool PollPlaces::has_place(const std::string& device) {
  auto next = line_.begin();
  for (auto free = taken_; free < per_second_; ++free) {
    while (next != line_.end() && scheduler_.now() - next->asked > kPatience) remove(next++);
    if (next == line_.end() || next->device == device) return true;
    ++next;
  }
  return false;
}

void PollPlaces::wait(const std::string& device) {
  if (const auto found = by_device_.find(device); found != by_device_.end()) {
    found->second->asked = scheduler_.now();
    return;
  }
  line_.push_back({device, scheduler_.now()});
  by_device_[device] = std::prev(line_.end());
}

void PollPlaces::remove(Line::iterator waiting) {
  by_device_.erase(waiting->device);
  line_.erase(waiting);
}

}  // namespace rubicon::networks::zigbee
