#include "tuples/dds/instance_quota.h"

#include <iterator>
#include <utility>

namespace rubicon::tuples::dds {

bool InstanceQuota::add(const Source& source, Handle instance, std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  auto& share = shares_[source.participant];
  const auto [writer, is_new] = writers_.try_emplace(source.writer);
  if (is_new) {
    writer->second.participant = source.participant;
    ++share.writers;
  }
  if (share.banned) return false;
  auto& instances = writer->second.instances;
  const auto found = instances.find(instance);
  const std::size_t replaced = found == instances.end() ? 0 : found->second.waiting_bytes;
  if (share.waiting_bytes - replaced + bytes > kMaxWaitingBytes) return false;
  if (found == instances.end() && share.instances >= most_) return false;
  if (found == instances.end()) ++share.instances;
  share.waiting_bytes += bytes - replaced;
  instances[instance] = {.waiting_bytes = bytes};
  return true;
}

void InstanceQuota::taken(Handle writer, Handle instance) {
  const std::lock_guard lock(mutex_);
  const auto found = writers_.find(writer);
  if (found == writers_.end()) return;
  const auto one = found->second.instances.find(instance);
  if (one == found->second.instances.end()) return;
  shares_[found->second.participant].waiting_bytes -= std::exchange(one->second.waiting_bytes, 0);
}

bool InstanceQuota::has(Handle writer, Handle instance) const {
  const std::lock_guard lock(mutex_);
  const auto found = writers_.find(writer);
  return found != writers_.end() && found->second.instances.contains(instance);
}

void InstanceQuota::unregistered(Handle writer, Handle instance) {
  const std::lock_guard lock(mutex_);
  const auto found = writers_.find(writer);
  if (found == writers_.end()) return;
  const auto one = found->second.instances.find(instance);
  if (one == found->second.instances.end()) return;
  one->second.unregistered = true;
  drop_if_over(found, one);
}

void InstanceQuota::gone(Handle writer) {
  const std::lock_guard lock(mutex_);
  const auto found = writers_.find(writer);
  if (found == writers_.end()) return;
  found->second.gone = true;
  auto& instances = found->second.instances;
  for (auto one = instances.begin(), next = one; one != instances.end(); one = next) {
    next = std::next(one);
    one->second.unregistered = true;
    drop_if_over(found, one);
  }
  drop_if_nothing(found);
}

void InstanceQuota::release(Handle writer, Handle instance) {
  const std::lock_guard lock(mutex_);
  const auto found = writers_.find(writer);
  if (found == writers_.end()) return;
  const auto one = found->second.instances.find(instance);
  if (one == found->second.instances.end()) return;
  one->second.end_taken = true;
  drop_if_over(found, one);
  drop_if_nothing(found);
}

void InstanceQuota::ban(Handle writer) {
  const std::lock_guard lock(mutex_);
  if (const auto found = writers_.find(writer); found != writers_.end())
    shares_[found->second.participant].banned = true;
}

void InstanceQuota::clear() {
  const std::lock_guard lock(mutex_);
  writers_.clear();
  shares_.clear();
}

std::size_t InstanceQuota::writers() const {
  const std::lock_guard lock(mutex_);
  return writers_.size();
}

void InstanceQuota::drop_if_over(Writers::iterator writer, std::map<Handle, Instance>::iterator instance) {
  if (!instance->second.unregistered || !instance->second.end_taken) return;
  auto& share = shares_[writer->second.participant];
  --share.instances;
  share.waiting_bytes -= instance->second.waiting_bytes;
  writer->second.instances.erase(instance);
}

void InstanceQuota::drop_if_nothing(Writers::iterator writer) {
  if (!writer->second.gone || !writer->second.instances.empty()) return;
  const auto share = shares_.find(writer->second.participant);
  if (--share->second.writers == 0) shares_.erase(share);
  writers_.erase(writer);
}

}  // namespace rubicon::tuples::dds
