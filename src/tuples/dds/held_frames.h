#pragma once

#include <deque>

#include "base/bytes.h"
#include "rubicon/time.hpp"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Frames that came before the presence of who sent them: kept for a while, bounded per participant and in all.
class HeldFrames {
 public:
  static constexpr std::size_t kMostOfOne = 1UL << 20, kMostOfAll = 4UL << 20;

  struct Sender {
    OwnerId id{};
    std::uint64_t incarnation = 0;
    Participant participant{};
    friend bool operator==(const Sender&, const Sender&) = default;
  };

  /// False: there is no room.
  bool add(const Sender& sender, ByteView content, SteadyTime now);
  /// Those of one sender, in their order; they are no longer held.
  std::vector<Bytes> take(const Sender& sender);
  /// What came then or before is dropped.
  void drop_until(SteadyTime time);
  bool empty() const { return all_.empty(); }
  /// Of all that is held, what it takes besides its content included.
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

}  // namespace rubicon::tuples::dds
