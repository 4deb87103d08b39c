#include "tuples/dds/early.h"

#include <cstdint>
#include <utility>

namespace rubicon::tuples::dds {

bool EarlyFrames::add(const Sender& sender, ByteView content, SteadyTime now) {
  const auto size = cost(content.size());
  const auto known = bytes_of_.find(sender.participant);
  const auto before = known == bytes_of_.end() ? 0 : known->second;
  if (before + size > kMaxOfOne || bytes_ + size > kMaxOfAll) return false;
  all_.push_back({sender, Bytes(content.begin(), content.end()), now});
  bytes_of_[sender.participant] += size;
  bytes_ += size;
  return true;
}

void EarlyFrames::forget(const Held& held) {
  const auto size = cost(held.content.size());
  bytes_ -= size;
  const auto found = bytes_of_.find(held.sender.participant);
  found->second -= size;
  if (found->second == 0) bytes_of_.erase(found);
}

std::vector<Bytes> EarlyFrames::take(const Sender& sender) {
  std::vector<Bytes> contents;
  for (auto& held : all_) {
    if (held.sender != sender) continue;
    forget(held);
    contents.push_back(std::move(held.content));
  }
  std::erase_if(all_, [&sender](const Held& held) { return held.sender == sender; });
  return contents;
}

void EarlyFrames::drop_until(SteadyTime time) {
  while (!all_.empty() && all_.front().since <= time) {
    forget(all_.front());
    all_.pop_front();
  }
}

void EarlyFrames::clear() {
  all_.clear();
  bytes_of_.clear();
  bytes_ = 0;
}

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
