#include "tuples/dds/heard_lists.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace rubicon::tuples::dds {

bool HeardLists::spend(Allowance& allowance) const {
  const auto from = std::max(allowance.spent_until, scheduler_.now());
  if (from - scheduler_.now() > (kAtOnce - 1) * kPause) return false;
  allowance.spent_until = from + kPause;
  return true;
}

void HeardLists::hear(const std::string& member, std::string_view list) {
  const bool has_room = members_.contains(member) || members_.size() < kMaxMembers;
  auto& allowance = members_[has_room ? member : std::string()];
  if (!allowance.waiting && spend(allowance)) return check_(std::string(list), member);
  allowance.waiting = Heard{std::string(list), member};
  if (!timer_.pending()) timer_ = scheduler_.after(kPause, [this] { check_waiting(); });
}

void HeardLists::check_waiting() {
  std::vector<Heard> lists;
  bool more = false;
  for (auto& [member, allowance] : members_) {
    if (!allowance.waiting) continue;
    if (spend(allowance))
      lists.push_back(*std::exchange(allowance.waiting, std::nullopt));
    else
      more = true;
  }
  if (more) timer_ = scheduler_.after(kPause, [this] { check_waiting(); });
  for (auto& one : lists) check_(std::move(one.list), one.member);
}

}  // namespace rubicon::tuples::dds
