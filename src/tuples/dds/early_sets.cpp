#include "tuples/dds/early_sets.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace rubicon::tuples::dds {

bool EarlySets::add(One one) {
  const auto size = sizeof(One) + one.set.key.size() + one.set.value.size() + one.set.media_type.size();
  auto& of_one = bytes_of_[one.set.from];
  if (of_one > kMaxOfOne || of_one + size > kMaxOfOne || bytes_ + size > kMaxOfAll) {
    of_one = SIZE_MAX;
    return false;
  }
  of_one += size;
  bytes_ += size;
  all_.push_back(std::move(one));
  return true;
}

std::deque<EarlySets::One> EarlySets::take(SteadyTime now) {
  auto taken = std::exchange(*this, {}).all_;
  std::erase_if(taken, [now](One& one) {
    auto& left = one.set.time_to_live;
    if (left == Duration(0)) return false;
    left -= std::min(left, now - one.since);
    return left == Duration(0);
  });
  return taken;
}

}  // namespace rubicon::tuples::dds
