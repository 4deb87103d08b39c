#include "tuples/dds/instance_quota.h"

namespace rubicon::tuples::dds {

Result<void> InstanceQuota::guard(dds_entity_t topic) {
  dds_topic_filter filter{};
  filter.mode = DDS_TOPIC_FILTER_SAMPLEINFO_ARG;
  filter.f.sampleinfo_arg = [](const dds_sample_info_t* sample, void* self) {
    return static_cast<InstanceQuota*>(self)->take(*sample);
  };
  filter.arg = this;
  if (const auto answer = dds_set_topic_filter_extended(topic, &filter); answer != DDS_RETCODE_OK)
    return fail(ErrorCode::kIo, std::string("DDS: a bound cannot be set: ") + dds_strretcode(-answer));
  return {};
}

bool InstanceQuota::take(const dds_sample_info_t& sample) {
  if (sample.publication_handle == 0) return true;  // an own writer of the topic asks too
  const std::lock_guard lock(mutex_);
  auto& used = writers_[sample.publication_handle];
  if (used.banned) return false;
  if (used.instances.contains(sample.instance_handle)) return true;
  return used.instances.size() < most_ && used.instances.insert(sample.instance_handle).second;
}

void InstanceQuota::release(dds_instance_handle_t writer, dds_instance_handle_t instance) {
  const std::lock_guard lock(mutex_);
  if (const auto found = writers_.find(writer); found != writers_.end()) found->second.instances.erase(instance);
}

void InstanceQuota::ban(dds_instance_handle_t writer) {
  const std::lock_guard lock(mutex_);
  writers_[writer] = {{}, true};
}

void InstanceQuota::keep_only(const std::set<dds_instance_handle_t>& there) {
  const std::lock_guard lock(mutex_);
  std::erase_if(writers_, [&there](const auto& one) { return !there.contains(one.first); });
}

}  // namespace rubicon::tuples::dds
