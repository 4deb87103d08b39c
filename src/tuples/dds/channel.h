#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "rubicon/tuple.hpp"
#include "tuples/dds/entity.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples::dds {

/// Everything that one component sends to one other, in order: a queue of entries before a DDS writer of its own, so
/// that a receiver that is slow delays no other. Does not block.
class Channel {
 public:
  /// Source and destination.
  struct Ends {
    OwnerId source{}, target{};
    std::uint64_t source_incarnation = 0, target_incarnation = 0;
  };

  /// `listener`, which must outlive the channel, is called on a thread of DDS when the destination can be reached.
  static Result<std::unique_ptr<Channel>> make(const Ends& ends, dds_entity_t participant, dds_entity_t topic,
                                               const dds_listener_t* listener);

  /// Entries encoded by a FrameWriter, at most kFrameBytes, or one longer entry.
  void add(Bytes changes);
  void add(RemoteSet set, SteadyTime now);
  void add(Reply reply);
  void add(const distant::IdentityCheck& check);
  /// Sends the times with the next frame, which may have nothing else. `asks`: for those of the destination.
  void add_times(bool asks);

  enum class State : std::uint8_t { kEmpty, kMore, kFull };
  /// With what a frame begins, before each one is written: `asks` as for add_times(). Empty: without times.
  using Times = std::function<distant::FrameTimes(bool asks)>;
  /// Writes at most kFramesPerTurn frames. kMore: continue in the next turn; kFull: the destination accepts nothing
  /// now.
  State flush(SteadyTime now, const Times& times = {});

  dds_entity_t writer() const { return writer_.get(); }
  /// Approximate number of bytes that wait.
  std::size_t waiting() const { return waiting_; }

  static constexpr std::size_t kFrameBytes = 32 * 1024;
  static constexpr int kFramesPerTurn = 64;

 private:
  struct TimedSet {
    RemoteSet set;
    SteadyTime since;
  };
  using Entry = std::variant<Bytes, TimedSet, Reply>;

  Channel(const Ends& ends, Entity publisher, Entity writer)
      : ends_(ends), publisher_(std::move(publisher)), writer_(std::move(writer)) {}
  bool has_readers();
  std::size_t fill(SteadyTime now, const Times& times);
  bool write();
  void push(Entry entry, std::size_t size);

  Ends ends_;
  Entity publisher_, writer_;
  bool matched_ = false;
  std::deque<std::pair<Entry, std::size_t>> entries_;
  std::size_t waiting_ = 0;
  bool times_due_ = false, asks_ = false;
  distant::FrameWriter frame_;
};

/// How long components that leave together wait for acknowledgements. Components that are cut off never answer, and a
/// program that ends has to be quick. Blocks the loop.
class Patience {
 public:
  static constexpr dds_duration_t kMax = DDS_MSECS(300);
  static constexpr dds_duration_t kRecovery = DDS_SECS(10);  ///< without a wait; then it is there again

  void await(dds_entity_t writer) {
    const auto begin = dds_time();
    if (begin - waited_ > kRecovery) left_ = kMax;
    dds_wait_for_acks(writer, left_);
    waited_ = dds_time();
    left_ = std::max<dds_duration_t>(left_ - (waited_ - begin), 0);
  }

 private:
  dds_duration_t left_ = kMax;
  dds_time_t waited_ = 0;
};

}  // namespace rubicon::tuples::dds
