#include "tuples/peis/kernel_subscribers.h"

#include <algorithm>

#include "tuples/peis/patterns.h"

namespace rubicon::tuples::peis {

namespace {

std::optional<std::string> folded_data(const std::optional<std::string_view>& data) {
  return data ? std::optional(folded(*data)) : std::nullopt;
}

}  // namespace

std::uint32_t KernelSubscribers::next_id() {
  do {
    if (++last_id_ == 0) last_id_ = 1;
  } while (by_id_.contains(last_id_));
  return last_id_;
}

Result<KernelSubscribers::Entry*> KernelSubscribers::add(const Subscribe& subscribe, SteadyTime now) {
  const auto& prototype = subscribe.prototype;
  auto pattern = from_kernel_pattern(prototype.key);
  if (!pattern) return fail(pattern.error());
  if (!subscribe.force_resend) {
    if (last_of_round_ == SteadyTime::min() || now - last_of_round_ > kRoundGap) ++round_;
    last_of_round_ = now;
  }
  const std::pair name(folded(prototype.key), folded_data(prototype.data));
  if (entries_.size() >= kMaxEntries && !entries_.contains(name))
    return fail(ErrorCode::kBusy, "too many subscriptions: one is ignored");
  auto& entry = entries_[name];
  if (entry.spellings.empty()) {
    entry.pattern = *pattern;
    entry.data = name.second;
    entry.media_type = prototype.media_type;
    entry.creator = prototype.creator;
    entry.spellings.push_back({next_id(), std::move(*pattern), false});
    by_id_[entry.spellings[0].id] = name;
  }
  if (entry.media_type != prototype.media_type) entry.media_type.clear();
  if (entry.creator != prototype.creator) entry.creator.reset();
  has_filters_ |= entry.data || !entry.media_type.empty() || entry.creator;
  if (subscribe.force_resend) {
    ++entry.forced;
    ++entry.forced_since;
  } else {
    if (std::exchange(entry.round, round_) != round_) entry.in_round = entry.forced_since = 0;
    ++entry.in_round;
  }
  return &entry;
}

std::vector<std::uint32_t> KernelSubscribers::remove(const Unsubscribe& unsubscribe) {
  const auto found = entries_.find({folded(unsubscribe.key), folded_data(unsubscribe.data)});
  if (found == entries_.end()) return {};
  auto& entry = found->second;
  const auto handles = std::max(entry.forced, entry.in_round + entry.forced_since);
  if (entry.forced > 0) --entry.forced;
  if (entry.forced_since > 0) {
    --entry.forced_since;
  } else if (entry.in_round > 0) {
    --entry.in_round;
  }
  if (handles > 1) return {};
  std::vector<std::uint32_t> ids;
  for (const auto& spelling : entry.spellings) {
    ids.push_back(spelling.id);
    by_id_.erase(spelling.id);
  }
  entries_.erase(found);
  return ids;
}

std::vector<std::uint32_t> KernelSubscribers::begin_again() {
  last_of_round_ = SteadyTime::min();
  std::vector<std::uint32_t> ids;
  for (auto& [name, entry] : entries_) {
    entry.forced = entry.in_round = entry.forced_since = 0;
    for (auto& spelling : entry.spellings) {
      spelling.snapshot_under_way = false;
      ids.push_back(spelling.id);
    }
  }
  return ids;
}

const KernelSubscribers::Spelling* KernelSubscribers::add_spelling(Entry& entry, std::string_view key) {
  if (is_folded(entry.pattern) && is_folded(key)) return nullptr;
  if (!matches_folded(entry.pattern, key) || entry.spellings.size() >= kMaxSpellings) return nullptr;
  const bool known = std::any_of(entry.spellings.begin(), entry.spellings.end(), [&](const Spelling& spelling) {
    return Pattern{{}, spelling.pattern}.matches({}, key);
  });
  if (known) return nullptr;
  entry.spellings.push_back({next_id(), spelled_as(entry.pattern, key), false});
  auto& added = entry.spellings.back();
  by_id_[added.id] = by_id_.at(entry.spellings.front().id);
  return &added;
}

KernelSubscribers::Spelling* KernelSubscribers::find(std::uint32_t id) {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return nullptr;
  auto& spellings = entries_.at(found->second).spellings;
  return &*std::find_if(spellings.begin(), spellings.end(),
                        [&](const Spelling& spelling) { return spelling.id == id; });
}

bool KernelSubscribers::accepts(const Entry& entry, std::string_view media_type, std::string_view data,
                                OwnerId creator) {
  if (!entry.media_type.empty() && entry.media_type != media_type) return false;
  if (entry.creator && *entry.creator != creator) return false;
  return !entry.data || *entry.data == folded(data);
}

bool KernelSubscribers::wants(std::string_view key, std::string_view media_type, std::string_view data,
                              OwnerId creator) const {
  if (!has_filters_) return true;
  return std::any_of(entries_.begin(), entries_.end(), [&](const auto& item) {
    return accepts(item.second, media_type, data, creator) && matches_folded(item.second.pattern, key);
  });
}

}  // namespace rubicon::tuples::peis
