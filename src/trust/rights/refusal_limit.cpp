#include "trust/rights/refusal_limit.h"

#include <algorithm>
#include <utility>

namespace rubicon::trust::rights {

RefusalLimit::Name& RefusalLimit::name(std::string_view who, SteadyTime now) {
  if (const auto known = names_.find(who); known != names_.end()) return known->second;
  if (names_.size() >= kMostNames)
    std::erase_if(names_, [now](const auto& one) { return one.second.more == 0 && now - one.second.hour >= kHour; });
  const bool has_room = names_.size() < kMostNames;
  return names_.try_emplace(std::string(has_room ? who : kOthers), Name{now, now, {}, 0, 0, 0}).first->second;
}

bool RefusalLimit::allow(std::string_view who) {
  const auto now = scheduler_.now();
  auto& one = name(who, now);
  if (now - one.second >= kSecond) one = {now, one.hour, one.report, 0, one.in_hour, one.more};
  if (now - one.hour >= kHour) {
    one.hour = now;
    one.in_hour = 0;
  }
  if (now - hour_ >= kHour) {
    hour_ = now;
    in_hour_ = 0;
  }
  const bool has_hour = one.in_hour < kPerHour && in_hour_ < kAllPerHour;
  if (one.in_second < kPerSecond && has_hour) {
    ++one.in_second;
    ++one.in_hour;
    ++in_hour_;
    return true;
  }
  if (one.more++ == 0) {
    one.report = has_hour ? one.second + kSecond : now + kPause;
    plan();
  }
  return false;
}

void RefusalLimit::plan() {
  auto next = SteadyTime::max();
  for (const auto& [who, one] : names_) {
    if (one.more > 0) next = std::min(next, one.report);
  }
  if (next == SteadyTime::max()) return;
  timer_ = scheduler_.at(next, [this] { report(scheduler_.now()); });
}

void RefusalLimit::report(SteadyTime now) {
  for (auto& [who, one] : names_) {
    if (one.more > 0 && one.report <= now) more_(who, std::exchange(one.more, 0));
  }
  plan();
}

void RefusalLimit::flush() {
  report(SteadyTime::max());
}

}  // namespace rubicon::trust::rights
