#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "base/bytes.h"
#include "rubicon/time.hpp"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// Frames that arrived before the presence of their sender, or while another start of it counted: kept for a while,
/// bounded per participant and in all.
class EarlyFrames {
 public:
  static constexpr std::size_t kMaxOfOne = 1UL << 20, kMaxOfAll = 4UL << 20;

  /// False: the bound is reached.
  bool add(const Sender& sender, ByteView content, SteadyTime now);
  /// Removes and returns the frames of one sender, in order.
  std::vector<Bytes> take(const Sender& sender);
  /// Drops the frames that arrived at or before `time`.
  void drop_until(SteadyTime time);
  bool empty() const { return all_.empty(); }
  /// Memory of all frames, including overhead.
  std::size_t bytes() const { return bytes_; }
  void clear();

 private:
  struct Held {
    Sender sender;
    Bytes content;
    SteadyTime since;
  };
  static std::size_t cost(std::size_t content) { return sizeof(Held) + 32 + content; }
  void forget(const Held& held);

  std::deque<Held> all_;
  std::map<Participant, std::size_t> bytes_of_;
  std::size_t bytes_ = 0;
};

/// Remote sets that arrived and whose age is not known yet, in order; bounded for each component and in all.
class EarlySets {
 public:
  static constexpr std::size_t kMaxOfOne = 32UL << 20, kMaxOfAll = 64UL << 20;

  struct One {
    RemoteSet set;
    Participant sender{};
    std::uint64_t incarnation = 0;   ///< of its sender
    std::optional<Duration> sent{};  ///< by the clock of its sender (FrameTimes)
    SteadyTime since{};              ///< when it was received
  };

  /// False: the bound is reached. Then nothing of that component is added until all are taken, so that what remains is
  /// what was sent first.
  bool add(One one);
  std::deque<One> take();
  bool empty() const { return all_.empty(); }
  bool has(OwnerId from) const { return bytes_of_.contains(from); }
  void clear() { *this = {}; }

 private:
  std::deque<One> all_;
  std::map<OwnerId, std::size_t> bytes_of_;  ///< SIZE_MAX: there is no more room
  std::size_t bytes_ = 0;
};

}  // namespace rubicon::tuples::dds
