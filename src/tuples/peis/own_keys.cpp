#include "tuples/peis/own_keys.h"

#include <algorithm>
#include <utility>

#include "tuples/peis/patterns.h"
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

}  // namespace rubicon::tuples::peis
