#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/expiring_queues.h"
#include "base/scheduler.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn::sink {

/// `command`, `client`, `sampling`, `probe`.
std::string_view to_string(Lane lane);

/// Packets waiting for a sink, in a bounded first-in-first-out queue for each lane. Packets of better lanes are taken
/// first, but a lane that was passed over kMaxPassed times is next, so that no lane starves. Owned by a Sink.
class SendQueue {
 public:
  /// Packets of better lanes that may be taken before the first packet of a lane.
  static constexpr unsigned kMaxPassed = 8;

  struct Callbacks {
    std::function<void()> ready;     ///< take() may return a packet; called in a later turn than push()
    std::function<void(Lane)> room;  ///< a lane that refused a packet has room again; in a later turn
  };

  /// `lane_size`: packets in a lane, at least 1.
  SendQueue(Scheduler& scheduler, std::size_t lane_size, Callbacks callbacks);
  SendQueue(const SendQueue&) = delete;
  SendQueue& operator=(const SendQueue&) = delete;

  /// kBusy: the lane is full. Asserts that the packet has 1 to 255 bytes.
  Result<void> push(Outgoing packet);
  /// Removes the packet to send next; nullopt if none waits.
  std::optional<Outgoing> take();
  /// Returns a packet that was taken and could not be sent to the front of its lane, even if the lane is full.
  void put_back(Outgoing packet);
  /// Calls `done` in a later turn.
  void report(SendCallback done, SendResult result);

  std::size_t waiting(Lane lane) const { return packets_.size(index_of(lane)); }
  /// Adds the counters `expired` and `waiting-<lane>`.
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  struct LaneState {
    unsigned passed = 0;   ///< packets of better lanes taken since its first packet came to the front
    bool refused = false;  ///< push() returned kBusy, and `room` was not called since
  };

  static std::size_t index_of(Lane lane) { return static_cast<std::size_t>(lane); }
  std::optional<std::size_t> next_lane() const;
  void count_passed(std::size_t taken);
  void expired(Outgoing packet);
  void notify_room();

  Scheduler& scheduler_;
  std::size_t lane_size_;
  Callbacks callbacks_;
  base::ExpiringQueues<Outgoing> packets_;  ///< one queue for each lane
  std::array<LaneState, kLanes> lanes_;
  std::uint64_t expired_ = 0;
  base::OncePerTurn ready_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
