#include "tuples/dds/participants.h"

#include <algorithm>

namespace rubicon::tuples::dds {

bool Participants::is_banned(const Participant& who) const {
  const auto found = shares_.find(who);
  return found != shares_.end() && found->second.banned;
}

bool Participants::add(const Participant& who, const Start& start) {
  auto& starts = shares_[who].starts;
  if (starts.size() >= kMaxComponents && !starts.contains(start)) return false;
  starts.insert(start);
  return true;
}

void Participants::remove(const Participant& who, const Start& start) {
  if (const auto found = shares_.find(who); found != shares_.end()) found->second.starts.erase(start);
  drop_if_nothing(who);
}

std::vector<Participants::Start> Participants::ban(const Participant& who) {
  auto& share = shares_[who];
  share.banned = true;
  const auto starts = std::exchange(share.starts, {});
  return {starts.begin(), starts.end()};
}

std::optional<Participant> Participants::largest() const {
  const auto found = std::max_element(shares_.begin(), shares_.end(), [](const auto& a, const auto& b) {
    return a.second.starts.size() < b.second.starts.size();
  });
  if (found == shares_.end() || found->second.starts.size() < 2) return std::nullopt;
  return found->first;
}

bool Participants::add_interest(const Participant& who, std::size_t bytes) {
  auto& share = shares_[who];
  const bool fits =
      share.interest_bytes + bytes <= kMaxInterestBytes && interest_bytes_ + bytes <= kMaxInterestBytesOfAll;
  if (fits) {
    share.interest_bytes += bytes;
    interest_bytes_ += bytes;
  }
  drop_if_nothing(who);
  return fits;
}

void Participants::remove_interest(const Participant& who, std::size_t bytes) {
  const auto found = shares_.find(who);
  if (found == shares_.end()) return;
  found->second.interest_bytes -= bytes;
  interest_bytes_ -= bytes;
  drop_if_nothing(who);
}

/// Components and interests are removed by their own callers.
void Participants::keep_only(const std::set<Participant>& there) {
  for (auto& [who, share] : shares_) share.banned &= there.contains(who);
  std::erase_if(shares_, [](const auto& one) { return one.second.is_nothing(); });
}

void Participants::drop_if_nothing(const Participant& who) {
  const auto found = shares_.find(who);
  if (found != shares_.end() && found->second.is_nothing()) shares_.erase(found);
}

void Participants::clear() {
  shares_.clear();
  interest_bytes_ = 0;
}

}  // namespace rubicon::tuples::dds
