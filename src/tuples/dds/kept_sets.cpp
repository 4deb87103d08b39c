#include "tuples/dds/kept_sets.h"

#include <tuple>

namespace rubicon::tuples::dds {

std::size_t UnansweredSets::size_of(const RemoteSet& set) {
  return sizeof(TimedSet) + 64 + set.key.size() + set.value.size();
}

bool UnansweredSets::add(const RemoteSet& set, SteadyTime now) {
  if (all_.size() >= many_) {
    std::ignore = still_waiting(now);
    many_ = 2 * all_.size() + 64;
  }
  const auto size = size_of(set);
  if (bytes_ + size > kMaxBytes || !all_.try_emplace(set.request, TimedSet{set, now}).second) return false;
  bytes_ += size;
  return true;
}

void UnansweredSets::answered(std::uint64_t request) {
  const auto found = all_.find(request);
  if (found == all_.end()) return;
  bytes_ -= size_of(found->second.set);
  all_.erase(found);
}

const std::map<std::uint64_t, UnansweredSets::TimedSet>& UnansweredSets::still_waiting(SteadyTime now) {
  std::erase_if(all_, [&](const auto& one) {
    const bool over = now - one.second.since >= one.second.set.time_to_live;
    if (over) bytes_ -= size_of(one.second.set);
    return over;
  });
  return all_;
}

void UnansweredSets::clear() {
  all_.clear();
  bytes_ = 0;
}

void RecentReplies::asked(OwnerId by, std::uint64_t request) {
  auto& open = components_[by].open;
  open.insert(request);
  if (open.size() > kMostOfOne) open.erase(open.begin());
}

void RecentReplies::answered(const Reply& reply) {
  const auto found = components_.find(reply.to);
  if (found == components_.end()) return;
  auto& [replies, open] = found->second;
  if (open.erase(reply.request) == 0) return;
  replies[reply.request] = {reply.verdict, reply.code, reply.sequence, next_};
  oldest_[next_++] = {reply.to, reply.request};
  if (replies.size() > kMostOfOne) erase(replies, replies.begin());
  while (oldest_.size() * kBytes > max_bytes_) {
    const auto [to, request] = oldest_.begin()->second;
    auto& others = components_.at(to).replies;
    erase(others, others.find(request));
  }
}

std::optional<Reply> RecentReplies::repeat(OwnerId to, std::uint64_t request) const {
  Reply reply{to,
              request,
              Verdict::kRefused,
              ErrorCode::kUnreachable,
              "the reply was lost, and whether the request was carried out is not known any more",
              0};
  const auto component = components_.find(to);
  if (component == components_.end()) return reply;
  const auto& [replies, open] = component->second;
  if (open.contains(request)) return {};
  const auto kept = replies.find(request);
  if (kept == replies.end()) return reply;
  const bool is_refused = kept->second.verdict != Verdict::kApplied;
  return Reply{to,
               request,
               kept->second.verdict,
               kept->second.code,
               is_refused ? "the text with the reason was lost with the first reply" : "",
               kept->second.sequence};
}

void RecentReplies::drop(OwnerId to) {
  const auto found = components_.find(to);
  if (found == components_.end()) return;
  auto& replies = found->second.replies;
  while (!replies.empty()) erase(replies, replies.begin());
}

void RecentReplies::forget(OwnerId component) {
  drop(component);
  components_.erase(component);
}

void RecentReplies::clear() {
  components_.clear();
  oldest_.clear();
}

void RecentReplies::erase(Replies& replies, Replies::iterator reply) {
  oldest_.erase(reply->second.order);
  replies.erase(reply);
}

}  // namespace rubicon::tuples::dds
