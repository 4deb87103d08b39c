#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>

namespace rubicon::tuples::dds {

/// Bounds how many instances of a topic DDS keeps for us from all writers of one participant. Cyclone keeps an instance
/// until its writer unregisters it or goes, and all that is in it was taken; so does this count it. The calls come on
/// threads of DDS too.
class InstanceQuota {
 public:
  using Handle = std::uint64_t;  ///< of a writer or an instance, as DDS names them
  using Prefix = std::array<std::uint32_t, 3>;
  /// A writer and the part of its name that all of its participant's have.
  struct Source {
    Handle writer = 0;
    Prefix participant{};
  };

  explicit InstanceQuota(std::size_t most) : most_(most) {}
  InstanceQuota(const InstanceQuota&) = delete;
  InstanceQuota& operator=(const InstanceQuota&) = delete;

  /// A value of an instance comes. False: there is no room for it.
  bool add(const Source& source, Handle instance);
  /// Only who has an instance may end it.
  bool has(Handle writer, Handle instance) const;
  void unregistered(Handle writer, Handle instance);
  void gone(Handle writer);
  /// The instance's end was taken from the reader.
  void release(Handle writer, Handle instance);
  /// No new value of this writer's participant from now on, as long as it is there.
  void ban(Handle writer);
  void clear();

  std::size_t writers() const;

 private:
  struct Instance {
    bool unregistered = false;
    bool end_taken = false;
  };
  struct Writer {
    Prefix participant{};
    std::map<Handle, Instance> instances;
    bool gone = false;
  };
  struct Share {
    std::size_t writers = 0, instances = 0;
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
