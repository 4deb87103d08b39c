#include "tuples/peis/kernel_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/translation.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

bool OwnKeys::add(std::string_view key) {
  auto& entry = entries_[folded(key)];
  if (entry.present) return entry.spelling == key;
  entry.spelling = key;
  entry.present = true;
  ++present_;
  if (!is_folded(key)) ++capitals_;
  return true;
}

bool OwnKeys::remove(std::string_view key, SteadyTime now) {
  drop_gone(now);
  const auto found = entries_.find(folded(key));
  if (found == entries_.end() || found->second.spelling != key) return false;
  if (std::exchange(found->second.present, false)) {
    --present_;
    if (!is_folded(key)) --capitals_;
  }
  found->second.gone_at = now;
  gone_.emplace_back(now, found->first);
  return true;
}

void OwnKeys::drop_gone(SteadyTime now) {
  while (!gone_.empty() && now - gone_.front().first > kKeepGone) {
    const auto found = entries_.find(gone_.front().second);
    if (found != entries_.end() && !found->second.present && found->second.gone_at == gone_.front().first) {
      if (found->second.numbered) least_ = std::max(least_, found->second.number + 1);
      entries_.erase(found);
    }
    gone_.pop_front();
  }
}

const std::string* OwnKeys::spelling(std::string_view key) const {
  const auto found = entries_.find(folded(key));
  return found != entries_.end() && found->second.present ? &found->second.spelling : nullptr;
}

void OwnKeys::each(std::string_view pattern, const std::function<void(const std::string&)>& visit) const {
  each_match(entries_, pattern, [&](auto at) {
    if (at->second.present) visit(at->second.spelling);
  });
}

std::string OwnKeys::list(std::string_view first, std::size_t limit) const {
  auto text = "(" + std::string(first);
  for (const auto& [key, entry] : entries_) {
    if (!entry.present || !check_peis_key(entry.spelling)) continue;
    if (text.size() + entry.spelling.size() + 2 > limit) break;
    if (text.size() > 1) text += ' ';
    text += entry.spelling;
  }
  return text + ")";
}

std::uint32_t OwnKeys::number_of(const TupleView& tuple) {
  const auto first = static_cast<std::uint32_t>(std::min<std::uint64_t>(tuple.sequence - 1, kMaxId));
  return number_of(tuple.key, {tuple.sequence, tuple.write_time, false}, first);
}

std::uint32_t OwnKeys::number_of(const TupleGone& gone) {
  if (!entries_.contains(folded(gone.key))) return least_++;
  return number_of(gone.key, {gone.sequence, {}, true}, 0);
}

std::uint32_t OwnKeys::number_of(std::string_view key, const Version& version, std::uint32_t least) {
  auto& entry = entries_[folded(key)];
  if (entry.spelling.empty()) entry.spelling = key;
  if (entry.numbered && entry.version == version) return entry.number;
  entry.number = entry.numbered ? std::max(entry.number + 1, least) : std::max(least, least_);
  entry.numbered = true;
  entry.version = version;
  return entry.number;
}

namespace {

/// The lifetime that the owner gave the tuple, from now on: the clocks of hosts differ.
SteadyTime end_of_copy(const NetworkTuple& tuple, SteadyTime now) {
  if (*tuple.expire_time == WallTime{}) return SteadyTime::max();
  return now + std::max<Duration>(*tuple.expire_time - *tuple.write_time, Duration(1));
}

}  // namespace

KernelCopies::News KernelCopies::take(const NetworkTuple& tuple, SteadyTime now) {
  const auto key = folded(tuple.key);
  const auto present = copies_.find(key);
  const bool known = present != copies_.end();
  if (known && present->second.confirmed) {
    const auto& copy = present->second;
    if (*tuple.sequence < copy.number) return News::kOld;
    if (*tuple.sequence == copy.number && tuple.appends == copy.appends) return News::kOld;
  }
  const auto before = known ? size_of(present->second) : 0;
  const auto size = tuple.key.size() + tuple.data->size() + tuple.media_type.size();
  if ((!known && copies_.size() >= kMaxCopies) || bytes_ - before + size > kMaxBytes) return News::kNoRoom;
  if (known) forget(*present);
  auto& copy = copies_[key];
  bytes_ += size;
  const auto first = std::uint64_t{*tuple.sequence} + 1;
  const auto sequence = known ? std::max(copy.sequence + 1, first) : first;
  copy = {std::string(tuple.key),
          std::string(*tuple.data),
          std::string(tuple.media_type),
          *tuple.encoding,
          *tuple.owner,
          *tuple.creator,
          *tuple.write_time,
          *tuple.user_time,
          *tuple.expire_time,
          *tuple.sequence,
          tuple.appends,
          sequence,
          true,
          end_of_copy(tuple, now)};
  if (copy.expires != SteadyTime::max()) expiries_.emplace(copy.expires, key);
  return News::kNew;
}

std::vector<const KernelCopies::Copy*> KernelCopies::append(const PushAppended& appended_to) {
  std::vector<const Copy*> changed;
  const auto& tuple = appended_to.tuple;
  const std::string_view pattern = tuple.key.empty() ? std::string_view("**") : tuple.key;
  each_match(copies_, pattern, [&](auto at) {
    auto& copy = at->second;
    if (tuple.sequence.value_or(copy.number) != copy.number) return;
    if (bytes_ + appended_to.difference.size() > kMaxBytes) return void(++refused_appends_);
    const auto before = copy.data.size();
    copy.data = appended(copy.encoding, copy.data, appended_to.difference);
    bytes_ += copy.data.size() - before;
    copy.appends = tuple.appends + 1;
    ++copy.sequence;
    if (tuple.write_time) copy.write_time = *tuple.write_time;
    changed.push_back(&copy);
  });
  return changed;
}

const KernelCopies::Copy* KernelCopies::find(std::string_view key) const {
  const auto found = copies_.find(folded(key));
  return found == copies_.end() ? nullptr : &found->second;
}

std::optional<KernelCopies::Copy> KernelCopies::remove(std::string_view key) {
  const auto found = copies_.find(folded(key));
  if (found == copies_.end()) return std::nullopt;
  forget(*found);
  return std::move(copies_.extract(found).mapped());
}

void KernelCopies::each(std::string_view pattern, const std::function<void(const Copy&)>& visit) const {
  each_match(copies_, pattern, [&](auto at) { visit(at->second); });
}

void KernelCopies::begin_round() {
  for (auto& [key, copy] : copies_) copy.confirmed = false;
}

void KernelCopies::end_round(std::string_view pattern) {
  std::vector<Copies::iterator> over;
  each_match(copies_, pattern, [&](auto at) {
    if (!at->second.confirmed) over.push_back(at);
  });
  for (const auto at : over) {
    forget(*at);
    copies_.erase(at);
  }
}

void KernelCopies::expire(SteadyTime now) {
  while (next_expiry() <= now) {
    const auto found = copies_.find(expiries_.begin()->second);
    forget(*found);
    copies_.erase(found);
  }
}

/// The item is about to be erased or replaced.
void KernelCopies::forget(const Copies::value_type& item) {
  bytes_ -= size_of(item.second);
  if (item.second.expires != SteadyTime::max()) expiries_.erase({item.second.expires, item.first});
}

TupleView view_of(const KernelCopies::Copy& copy, std::string_view key) {
  TupleView view;
  view.owner = copy.owner;
  view.key = key;
  view.value = from_kernel(copy.encoding, copy.data, copy.media_type);
  view.media_type = copy.media_type;
  view.creator = copy.creator;
  view.sequence = copy.sequence;
  view.write_time = copy.write_time;
  view.user_time = copy.user_time;
  view.expire_time = copy.expire_time;
  return view;
}

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
    return fail(ErrorCode::kBusy, "too many bytes of data in subscriptions: one is ignored");
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
