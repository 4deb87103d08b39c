#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn::sink {

/// `command`, `client`, `sampling`, `probe`.
std::string_view to_string(Lane lane);

/// Packets that wait for a sink: a lane each for who wants them sent, bounded, in order within one. A better lane goes
/// first, but only so often: none waits for ever. Belongs to a Sink.
class SendQueue {
 public:
  /// So many packets of better lanes may pass a lane by; then it is its turn.
  static constexpr unsigned kPatience = 8;

  struct Calls {
    std::function<void()> ready;     ///< take() may give something; called in a later turn than the push()
    std::function<void(Lane)> room;  ///< a lane that refused has room again; in a later turn
  };

  /// `lane_size`: at least 1.
  SendQueue(Scheduler& scheduler, std::size_t lane_size, Calls calls);
  ~SendQueue();
  SendQueue(const SendQueue&) = delete;
  SendQueue& operator=(const SendQueue&) = delete;

  /// kBusy: its lane is full. The packet has 1 to 255 bytes: asserted.
  Result<void> push(Outgoing packet);
  /// The packet to send now; it is no longer here then.
  std::optional<Outgoing> take();
  /// A packet that was taken and could not leave: it goes first in its lane again, whether there is room or not.
  void put_back(Outgoing packet);
  /// Calls `done` in a later turn.
  void report(SendCallback done, SendResult what);

  std::size_t waiting(Lane lane) const;
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  struct Waiting {
    std::deque<Outgoing> packets;
    unsigned passed = 0;   ///< packets of better lanes that went before its first
    bool refused = false;  ///< somebody waits for room
  };

  Waiting* next();
  void count_passed(const Waiting& taken);
  void expire();
  void expire_in(Waiting& lane, SteadyTime now, SteadyTime& next);
  void watch(SteadyTime expires);
  void tell_room();
  void tell_ready();

  Scheduler& scheduler_;
  std::size_t lane_size_;
  Calls calls_;
  std::array<Waiting, kLanes> lanes_;
  std::uint64_t expired_ = 0;
  bool ready_asked_ = false;
  SteadyTime next_expiry_ = SteadyTime::max();
  Timer expiry_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::wsn::sink
