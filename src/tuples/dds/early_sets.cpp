#include "tuples/dds/early_sets.h"

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

std::deque<EarlySets::One> EarlySets::take() {
  return std::exchange(*this, {}).all_;
}

}  // namespace rubicon::tuples::dds
