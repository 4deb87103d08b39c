#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>

namespace rubicon::tuples::dds {

/// Limits what a reader keeps for one writer: the number of instances, and the bytes of values that were not taken yet.
/// DDS asks it as a filter of the topic, on its own threads, before it keeps a value. Of each instance it keeps the
/// last value. Thread-safe.
class InstanceQuota {
 public:
  using Handle = std::uint64_t;  ///< DDS handle of a writer or an instance

  static constexpr std::size_t kMaxWaitingBytes = 4UL << 20;

  explicit InstanceQuota(std::size_t most) : most_(most) {}
  InstanceQuota(const InstanceQuota&) = delete;
  InstanceQuota& operator=(const InstanceQuota&) = delete;

  /// A value of so many bytes arrives for an instance. False: a limit is reached.
  bool add(Handle writer, Handle instance, std::size_t bytes);
  /// The value was taken from the reader.
  void taken(Handle writer, Handle instance);
  /// The end of the instance was taken from the reader.
  void ended(Handle writer, Handle instance);
  /// Accepts no new values from this writer.
  void ban(Handle writer);
  /// Forgets all writers but these.
  void keep_only(const std::set<Handle>& there);

  std::size_t writers() const;

 private:
  struct Share {
    std::map<Handle, std::size_t> waiting;  ///< bytes, by instance
    std::size_t waiting_bytes = 0;
    bool banned = false;
  };

  std::size_t most_;
  mutable std::mutex mutex_;
  std::map<Handle, Share> shares_;  ///< by writer
};

/// Makes the quota the filter of a topic of that type. It outlives the topic. False: DDS refuses.
bool bound_presences(std::int32_t topic, InstanceQuota& quota);
bool bound_interests(std::int32_t topic, InstanceQuota& quota);

}  // namespace rubicon::tuples::dds
