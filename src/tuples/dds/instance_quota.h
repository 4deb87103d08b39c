#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>

namespace rubicon::tuples::dds {

/// Limits what DDS keeps of a topic for all writers of one participant: the number of instances, and the bytes of
/// samples that were not taken yet. Cyclone keeps an instance until its writer unregistered it or is gone, and all its
/// samples were taken; it counts here for as long. Of each instance it keeps the last sample. Thread-safe.
class InstanceQuota {
 public:
  using Handle = std::uint64_t;  ///< DDS handle of a writer or an instance
  using Prefix = std::array<std::uint32_t, 3>;
  /// A writer, and the prefix of its GUID, which all writers of a participant share.
  struct Source {
    Handle writer = 0;
    Prefix participant{};
  };

  static constexpr std::size_t kMaxWaitingBytes = 4UL << 20;

  explicit InstanceQuota(std::size_t most) : most_(most) {}
  InstanceQuota(const InstanceQuota&) = delete;
  InstanceQuota& operator=(const InstanceQuota&) = delete;

  /// A value of so many bytes arrives for an instance. False: a limit is reached.
  bool add(const Source& source, Handle instance, std::size_t bytes);
  /// Whether the writer has the instance: only then it may end it.
  bool has(Handle writer, Handle instance) const;
  void unregistered(Handle writer, Handle instance);
  void gone(Handle writer);
  /// The value was taken from the reader.
  void taken(Handle writer, Handle instance);
  /// The instance's end was taken from the reader.
  void release(Handle writer, Handle instance);
  /// Accepts no new values from the participant of this writer for as long as it is present.
  void ban(Handle writer);
  void clear();

  std::size_t writers() const;

 private:
  struct Instance {
    std::size_t waiting_bytes = 0;
    bool unregistered = false;
    bool end_taken = false;
  };
  struct Writer {
    Prefix participant{};
    std::map<Handle, Instance> instances;
    bool gone = false;
  };
  struct Share {
    std::size_t writers = 0, instances = 0, waiting_bytes = 0;
    bool banned = false;
  };
  using Writers = std::map<Handle, Writer>;

  void drop_if_over(Writers::iterator writer, std::map<Handle, Instance>::iterator instance);
  void drop_if_nothing(Writers::iterator writer);

  std::size_t most_;
  mutable std::mutex mutex_;
  Writers writers_;
  std::map<Prefix, Share> shares_;
};

}  // namespace rubicon::tuples::dds
