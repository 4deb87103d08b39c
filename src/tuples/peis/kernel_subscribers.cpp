#include "tuples/peis/kernel_subscribers.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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

Result<void> KernelSubscribers::check_room(const Name& name) const {
  if (entries_.contains(name)) return {};
  if (entries_.size() >= kMaxEntries) return fail(ErrorCode::kBusy, "too many subscriptions: one is ignored");
  if (data_bytes_ + data_size(name) > kMaxDataOfAll)
    return fail(ErrorCode::kBusy, "too many subscriptions with data: one is ignored");
  return {};
}

/// A new one has no spelling yet.
Result<KernelSubscribers::Item*> KernelSubscribers::obtain(const NetworkTuple& prototype) {
  auto pattern = from_kernel_pattern(prototype.key);
  if (!pattern) return fail(pattern.error());
  if (prototype.data && prototype.data->size() > kMaxData)
    return fail(ErrorCode::kOutOfRange, fmt::format("its data have {} bytes, at most {} are compared: it is ignored",
                                                    prototype.data->size(), kMaxData));
  Name name(folded(prototype.key), folded_data(prototype.data));
  if (const auto room = check_room(name); !room) return fail(room.error());
  const auto [at, is_new] = entries_.try_emplace(std::move(name));
  auto& [kept, entry] = *at;
  if (!is_new) return &*at;
  data_bytes_ += data_size(kept);
  entry.pattern = *pattern;
  entry.media_type = prototype.media_type;
  entry.creator = prototype.creator;
  entry.spellings.push_back({next_id(), std::move(*pattern)});
  const auto id = entry.spellings[0].id;
  by_id_[id] = &*at;
  if (entry.pattern.find('*') != entry.pattern.npos) wild_[id] = &*at;
  if (is_filter(*at)) ++filters_;
  return &*at;
}

Result<KernelSubscribers::Entry*> KernelSubscribers::add(const Subscribe& subscribe, SteadyTime now) {
  const auto& prototype = subscribe.prototype;
  const auto obtained = obtain(prototype);
  if (!obtained) return fail(obtained.error());
  auto& item = **obtained;
  auto& entry = item.second;
  const bool was_filter = is_filter(item);
  if (entry.media_type != prototype.media_type) entry.media_type.clear();
  if (entry.creator != prototype.creator) entry.creator.reset();
  if (was_filter && !is_filter(item)) --filters_;
  count(entry, subscribe.force_resend, now);
  return &entry;
}

void KernelSubscribers::count(Entry& entry, bool forced, SteadyTime now) {
  if (forced) {
    ++entry.forced;
    ++entry.forced_since;
    return;
  }
  if (last_of_round_ == SteadyTime::min() || now - last_of_round_ > kRoundGap) ++round_;
  last_of_round_ = now;
  if (std::exchange(entry.round, round_) != round_) entry.in_round = entry.forced_since = 0;
  ++entry.in_round;
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
  if (is_filter(*found)) --filters_;
  data_bytes_ -= data_size(found->first);
  std::vector<std::uint32_t> ids;
  for (const auto& spelling : entry.spellings) {
    ids.push_back(spelling.id);
    by_id_.erase(spelling.id);
    wild_.erase(spelling.id);
  }
  entries_.erase(found);
  return ids;
}

std::vector<std::uint32_t> KernelSubscribers::begin_again() {
  last_of_round_ = SteadyTime::min();
  for (auto& [name, entry] : entries_) {
    entry.forced = entry.in_round = entry.forced_since = 0;
    for (auto& spelling : entry.spellings) spelling.snapshot_under_way = spelling.again = false;
  }
  return ids();
}

std::vector<std::uint32_t> KernelSubscribers::ids() const {
  std::vector<std::uint32_t> all;
  for (const auto& [id, item] : by_id_) all.push_back(id);
  return all;
}

void KernelSubscribers::each_for(std::string_view key, const std::function<void(Entry&)>& visit) {
  Name name(folded(key), std::nullopt);
  for (auto at = entries_.lower_bound(name); at != entries_.end() && at->first.first == name.first; ++at)
    visit(at->second);
  for (const auto& [id, item] : wild_) {
    if (matches_folded(item->second.pattern, key)) visit(item->second);
  }
}

bool KernelSubscribers::any_for(std::string_view key, const std::function<bool(const Item&)>& is_it) const {
  const Name name(folded(key), std::nullopt);
  for (auto at = entries_.lower_bound(name); at != entries_.end() && at->first.first == name.first; ++at) {
    if (is_it(*at)) return true;
  }
  return std::any_of(wild_.begin(), wild_.end(), [&](const auto& one) {
    return matches_folded(one.second->second.pattern, key) && is_it(*one.second);
  });
}

const KernelSubscribers::Spelling* KernelSubscribers::add_spelling(Entry& entry, std::string_view key) {
  if (is_folded(entry.pattern) && is_folded(key)) return nullptr;
  if (!matches_folded(entry.pattern, key) || entry.spellings.size() >= kMaxSpellings) return nullptr;
  const bool known = std::any_of(entry.spellings.begin(), entry.spellings.end(), [&](const Spelling& spelling) {
    return Pattern{{}, spelling.pattern}.matches({}, key);
  });
  if (known) return nullptr;
  entry.spellings.push_back({next_id(), spelled_as(entry.pattern, key)});
  auto& added = entry.spellings.back();
  by_id_[added.id] = by_id_.at(entry.spellings.front().id);
  return &added;
}

KernelSubscribers::Spelling* KernelSubscribers::find(std::uint32_t id) {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return nullptr;
  auto& spellings = found->second->second.spellings;
  return &*std::find_if(spellings.begin(), spellings.end(),
                        [&](const Spelling& spelling) { return spelling.id == id; });
}

bool KernelSubscribers::is_filter(const Item& item) {
  return item.first.second || !item.second.media_type.empty() || item.second.creator;
}

bool KernelSubscribers::wants(std::string_view key, std::string_view media_type, std::string_view data,
                              OwnerId creator) const {
  if (filters_ == 0) return true;
  std::optional<std::string> value;
  const auto is_data = [&](const std::string& wanted) {
    if (wanted.size() != data.size()) return false;
    if (!value) value = folded(data);
    return wanted == *value;
  };
  return any_for(key, [&](const Item& item) {
    const auto& [name, entry] = item;
    if (!entry.media_type.empty() && entry.media_type != media_type) return false;
    if (entry.creator && *entry.creator != creator) return false;
    return !name.second || is_data(*name.second);
  });
}

}  // namespace rubicon::tuples::peis
