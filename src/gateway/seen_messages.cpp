#include "gateway/seen_messages.h"

#include <algorithm>

namespace rubicon::gateway {

bool SeenMessages::seen(IslandId origin, std::uint64_t number) const {
  const auto found = windows_.find(origin);
  if (found == windows_.end() || number > found->second.highest) return false;
  const auto& numbers = found->second.numbers;
  return std::find(numbers.begin(), numbers.end(), number) != numbers.end();
}

void SeenMessages::note(IslandId origin, std::uint64_t number) {
  Window& known = window(origin);
  known.highest = std::max(known.highest, number);
  if (known.numbers.size() < kNumbers) {
    known.numbers.push_back(number);
    return;
  }
  known.numbers[known.next] = number;
  known.next = (known.next + 1) % kNumbers;
}

SeenMessages::Window& SeenMessages::window(IslandId origin) {
  if (const auto found = windows_.find(origin); found != windows_.end()) {
    by_age_.splice(by_age_.begin(), by_age_, found->second.age);
    return found->second;
  }
  if (windows_.size() >= kOrigins) {
    windows_.erase(by_age_.back());
    by_age_.pop_back();
  }
  by_age_.push_front(origin);
  Window& fresh = windows_[origin];
  fresh.age = by_age_.begin();
  return fresh;
}

}  // namespace rubicon::gateway
