#include "tuples/dds/reader_stores.h"

#include <dds/dds.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

bool InstanceQuota::add(Handle writer, Handle instance, std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  auto& share = shares_[writer];
  if (share.banned) return false;
  const auto known = share.waiting.find(instance);
  const std::size_t replaced = known == share.waiting.end() ? 0 : known->second;
  if (share.waiting_bytes - replaced + bytes > kMaxWaitingBytes) return false;
  if (known == share.waiting.end() && share.waiting.size() >= most_) return false;
  share.waiting_bytes += bytes - replaced;
  share.waiting[instance] = bytes;
  return true;
}

void InstanceQuota::taken(Handle writer, Handle instance) {
  const std::lock_guard lock(mutex_);
  const auto share = shares_.find(writer);
  if (share == shares_.end()) return;
  if (const auto one = share->second.waiting.find(instance); one != share->second.waiting.end())
    share->second.waiting_bytes -= std::exchange(one->second, 0);
}

void InstanceQuota::ended(Handle writer, Handle instance) {
  const std::lock_guard lock(mutex_);
  const auto share = shares_.find(writer);
  if (share == shares_.end()) return;
  if (const auto one = share->second.waiting.find(instance); one != share->second.waiting.end()) {
    share->second.waiting_bytes -= one->second;
    share->second.waiting.erase(one);
  }
  if (share->second.waiting.empty() && !share->second.banned) shares_.erase(share);
}

void InstanceQuota::ban(Handle writer) {
  const std::lock_guard lock(mutex_);
  shares_[writer].banned = true;
}

void InstanceQuota::keep_only(const std::set<Handle>& there) {
  const std::lock_guard lock(mutex_);
  std::erase_if(shares_, [&there](const auto& one) { return !there.contains(one.first); });
}

std::size_t InstanceQuota::writers() const {
  const std::lock_guard lock(mutex_);
  return shares_.size();
}

namespace {

bool has_instance(dds_entity_t reader, InstanceQuota::Handle instance) {
  void* samples[1] = {};
  dds_sample_info_t infos[1];
  const auto found = dds_read_instance(reader, samples, infos, 1, 1, instance);
  if (found > 0) dds_return_loan(reader, samples, found);
  return found >= 0;
}

}  // namespace

/// Instances that their writer unregistered are gone by then.
bool EndedInstances::add(std::int32_t reader, InstanceQuota::Handle instance) {
  if (over_) return false;
  kept_.insert(instance);
  if (kept_.size() <= kMaxKept) return true;
  std::erase_if(kept_, [reader](auto one) { return !has_instance(reader, one); });
  over_ = kept_.size() > kMaxKept / 2;  // else the next look is at least so many ends later
  return !over_;
}

namespace {

std::size_t size_of(const rubicon_wire_Presence& presence) {
  return sizeof presence + std::strlen(presence.host) + std::strlen(presence.summary);
}

std::size_t size_of(const rubicon_wire_Interest& interest) {
  return sizeof interest + interest.content._length;
}

/// DDS asks for values only, not for the ends of instances; and a writer of this process before it writes, without its
/// handle.
template <class Sample>
bool set_filter(dds_entity_t topic, InstanceQuota& quota) {
  dds_topic_filter filter{};
  filter.mode = DDS_TOPIC_FILTER_SAMPLE_SAMPLEINFO_ARG;
  filter.f.sample_sampleinfo_arg = [](const void* sample, const dds_sample_info_t* info, void* arg) {
    if (info->publication_handle == 0) return true;
    return static_cast<InstanceQuota*>(arg)->add(info->publication_handle, info->instance_handle,
                                                 size_of(*static_cast<const Sample*>(sample)));
  };
  filter.arg = &quota;
  return dds_set_topic_filter_extended(topic, &filter) == DDS_RETCODE_OK;
}

}  // namespace

bool bound_presences(std::int32_t topic, InstanceQuota& quota) {
  return set_filter<rubicon_wire_Presence>(topic, quota);
}

bool bound_interests(std::int32_t topic, InstanceQuota& quota) {
  return set_filter<rubicon_wire_Interest>(topic, quota);
}

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

namespace {

/// With the node of the map.
std::size_t cost(const SubscriptionSpec& spec) {
  return sizeof(SubscriptionSpec) + sizeof(Participant) + 64 + spec.pattern.key.size();
}

}  // namespace

const SubscriptionSpec* Interests::find(const InterestKey& key, const Participant& who) const {
  const auto slots = all_.find(start_of(key, who));
  if (slots == all_.end()) return nullptr;
  const auto found = slots->second.find(key.slot);
  return found == slots->second.end() ? nullptr : &found->second;
}

bool Interests::put(const InterestKey& key, const Participant& who, SubscriptionSpec spec) {
  erase(key, who);
  const auto slots = all_.find(start_of(key, who));
  if (slots != all_.end() && slots->second.size() >= kMaxOfOne) return false;
  if (!participants_.add_interest(who, cost(spec))) return false;
  all_[start_of(key, who)].insert_or_assign(key.slot, std::move(spec));
  return true;
}

void Interests::erase(const InterestKey& key, const Participant& who) {
  const auto slots = all_.find(start_of(key, who));
  if (slots == all_.end()) return;
  const auto found = slots->second.find(key.slot);
  if (found == slots->second.end()) return;
  participants_.remove_interest(who, cost(found->second));
  slots->second.erase(found);
  if (slots->second.empty()) all_.erase(slots);
}

std::vector<SubscriptionSpec> Interests::of(OwnerId subscriber, std::uint64_t incarnation,
                                            const Participant& who) const {
  std::vector<SubscriptionSpec> specs;
  const auto slots = all_.find({subscriber, incarnation, who});
  if (slots == all_.end()) return specs;
  for (const auto& [slot, spec] : slots->second) specs.push_back(spec);
  return specs;
}

void Interests::erase_all(const Participant& who) {
  std::vector<InterestKey> gone;
  for (const auto& [start, slots] : all_) {
    const auto& [subscriber, incarnation, participant] = start;
    if (participant != who) continue;
    for (const auto& [slot, spec] : slots) gone.push_back({subscriber, incarnation, slot});
  }
  for (const auto& key : gone) erase(key, who);
}

std::set<Participant> Interests::participants() const {
  std::set<Participant> all;
  for (const auto& [start, slots] : all_) all.insert(std::get<Participant>(start));
  return all;
}

}  // namespace rubicon::tuples::dds
