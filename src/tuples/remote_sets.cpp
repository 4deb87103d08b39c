#include "tuples/remote_sets.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace rubicon::tuples {

namespace {

/// Wires count in microseconds, and 0 means no end there.
bool has_ended(const HeldSets::Held& one, SteadyTime now) {
  const auto lives = one.set.time_to_live;
  return lives < Duration(0) || (lives > Duration(0) && lives - (now - one.since) < std::chrono::microseconds(1));
}

}  // namespace

bool HeldSets::hold(const RemoteSet& set, SteadyTime now) {
  if (count_ >= kMax) drop_ended(now);
  if (count_ >= kMax || bytes_ + set.value.size() > kMaxBytes) return false;
  held_[set.owner].push_back({set, now});
  ++count_;
  bytes_ += set.value.size();
  return true;
}

std::vector<RemoteSet> HeldSets::take(OwnerId owner, SteadyTime now) {
  auto taken = held_.extract(owner);
  std::vector<RemoteSet> sets;
  if (taken.empty()) return sets;
  for (auto& [set, since] : taken.mapped()) {
    --count_;
    bytes_ -= set.value.size();
    if (has_ended({set, since}, now)) continue;
    if (set.time_to_live > Duration(0)) set.time_to_live -= now - since;
    sets.push_back(std::move(set));
  }
  return sets;
}

void HeldSets::drop_ended(SteadyTime now) {
  for (auto of_owner = held_.begin(); of_owner != held_.end();) {
    std::erase_if(of_owner->second, [&](const Held& one) {
      const bool ended = has_ended(one, now);
      count_ -= ended ? 1 : 0;
      bytes_ -= ended ? one.set.value.size() : 0;
      return ended;
    });
    of_owner = of_owner->second.empty() ? held_.erase(of_owner) : std::next(of_owner);
  }
}

std::vector<OwnerId> HeldSets::owners() const {
  std::vector<OwnerId> all;
  for (const auto& one : held_) all.push_back(one.first);
  return all;
}

void HeldSets::clear() {
  held_.clear();
  count_ = bytes_ = 0;
}

namespace {

constexpr Duration kStep = std::chrono::milliseconds(10);  ///< between two looks at what is open

/// Orders patterns from narrow to wide: without wildcard, with `*`, with `**`; then by the number of literal parts.
auto width(const Pattern& pattern) {
  std::size_t literal = 0;
  const auto parts = model::key_parts(pattern.key);
  for (const auto part : parts) literal += part != "*" && part != "**";
  return std::tuple(!pattern.exact(), parts.back() == "**", model::kMaxKeyParts - literal);
}

}  // namespace

Requests::Requests(OwnerId self, Scheduler& scheduler) : self_(self), scheduler_(scheduler) {}

void Requests::open(std::uint64_t request, OwnerId owner, Duration time_to_live, ReplyCall call) {
  const auto ends = scheduler_.now() + time_to_live;
  open_.emplace(request, Open{owner, std::move(call), ends, true});
  next_.advance_to(ends);
}

void Requests::expire() {
  const auto now = scheduler_.now();
  auto next = SteadyTime::max();
  std::vector<std::tuple<SteadyTime, std::uint64_t, OwnerId, bool>> over;
  for (const auto& [request, one] : open_) {
    if (one.ends <= now) over.emplace_back(one.ends, request, one.owner, one.left);
    if (one.ends > now) next = std::min(next, one.ends);
  }
  if (next != SteadyTime::max()) next_.set_at(std::max(next, now + kStep));
  std::sort(over.begin(), over.end());
  const auto alive = lifetime_.watch();
  for (const auto& [ends, request, owner, left] : over) {
    if (alive.ended()) return;
    answer(owner, left ? Reply{self_, request, Verdict::kTimedOut, ErrorCode::kExpired,
                               "no answer within the time to live: it is not known whether it was executed"}
                       : Reply{self_, request, Verdict::kExpired, ErrorCode::kExpired,
                               "its owner was not found within the time to live: it was not sent"});
  }
}

void Requests::set_left(std::uint64_t request, bool left) {
  if (const auto found = open_.find(request); found != open_.end()) found->second.left = left;
}

std::optional<Duration> Requests::remaining(std::uint64_t request) const {
  const auto found = open_.find(request);
  if (found == open_.end()) return std::nullopt;
  return found->second.ends - scheduler_.now();
}

bool Requests::answer(OwnerId from, const Reply& reply) {
  const auto found = open_.find(reply.request);
  if (found == open_.end()) return true;  // late
  if (found->second.owner != from) return false;
  const auto node = open_.extract(found);
  if (node.mapped().call) node.mapped().call(reply);
  return true;
}

std::shared_ptr<SetPolicies::PolicyEntry> SetPolicies::add(const Pattern& pattern, SetPolicy policy,
                                                           PolicyScope scope) {
  auto entry = std::make_shared<PolicyEntry>(PolicyEntry{pattern, std::move(policy), scope});
  const auto wider = [](const auto& one, const auto& other) { return width(one->pattern) < width(other->pattern); };
  entries_.insert(std::upper_bound(entries_.begin(), entries_.end(), entry, wider), entry);
  return entry;
}

std::shared_ptr<SetPolicies::PolicyEntry> SetPolicies::find(OwnerId self, std::string_view key) const {
  for (const auto& entry : entries_) {
    if (entry->pattern.matches(self, key)) return entry;
  }
  return nullptr;
}

}  // namespace rubicon::tuples
