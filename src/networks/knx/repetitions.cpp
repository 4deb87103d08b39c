#include "networks/knx/repetitions.h"

#include <algorithm>

namespace rubicon::networks::knx {

namespace {

constexpr Duration kRepetitionTime = std::chrono::milliseconds(200);
constexpr std::size_t kMaxRecent = 16;

bool same(const wire::Telegram& one, const wire::Telegram& other) {
  return one.service == other.service && one.destination == other.destination && one.source == other.source &&
         one.payload == other.payload;
}

}  // namespace

bool Repetitions::contain(const wire::Telegram& telegram, SteadyTime now) {
  while (!recent_.empty() && (recent_.size() > kMaxRecent || recent_.front().first + kRepetitionTime < now))
    recent_.pop_front();
  const auto is_same = [&](const auto& one) { return same(one.second, telegram); };
  if (telegram.repeated && std::any_of(recent_.begin(), recent_.end(), is_same)) {
    ++count_;
    return true;
  }
  recent_.emplace_back(now, telegram);
  return false;
}

}  // namespace rubicon::networks::knx
