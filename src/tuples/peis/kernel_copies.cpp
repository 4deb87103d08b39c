#include "tuples/peis/kernel_copies.h"

#include <algorithm>

#include "tuples/peis/patterns.h"
#include "tuples/peis/values.h"

namespace rubicon::tuples::peis {

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

}  // namespace rubicon::tuples::peis
