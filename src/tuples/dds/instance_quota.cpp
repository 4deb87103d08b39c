#include "tuples/dds/instance_quota.h"

#include <dds/dds.h>

#include <cstring>
#include <utility>

#include "wire.h"

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

}  // namespace rubicon::tuples::dds
