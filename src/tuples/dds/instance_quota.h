#pragma once

#include <map>
#include <mutex>
#include <set>

#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// Bounds how many instances of a topic DDS keeps for us from one writer: what is beyond never gets into the reader,
/// whose memory grows with them otherwise. Outlives the topic.
class InstanceQuota {
 public:
  explicit InstanceQuota(std::size_t most) : most_(most) {}
  InstanceQuota(const InstanceQuota&) = delete;
  InstanceQuota& operator=(const InstanceQuota&) = delete;

  /// Of a topic before its reader is made.
  Result<void> guard(dds_entity_t topic);
  /// The instance is not there any more.
  void release(dds_instance_handle_t writer, dds_instance_handle_t instance);
  /// Nothing new of this writer from now on.
  void ban(dds_instance_handle_t writer);
  /// Forgets all other writers.
  void keep_only(const std::set<dds_instance_handle_t>& there);

 private:
  struct Used {
    std::set<dds_instance_handle_t> instances;
    bool banned = false;
  };
  bool take(const dds_sample_info_t& sample);  // on a thread of DDS

  std::size_t most_;
  std::mutex mutex_;
  std::map<dds_instance_handle_t, Used> writers_;
};

}  // namespace rubicon::tuples::dds
