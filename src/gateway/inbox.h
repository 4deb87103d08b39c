#pragma once

#include <limits>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gateway/gateway.h"

namespace rubicon::gateway {

/// What one network said and nobody heard yet, in order and bounded: of readings the oldest are dropped, of joins and
/// signs of life the latest per device is kept, the rest is refused once there is no room.
class Inbox {
 public:
  Inbox(std::string network, GatewayLimits limits) : network_(std::move(network)), limits_(limits) {}

  void limit(GatewayLimits limits) { limits_ = limits; }
  const std::string& network() const { return network_; }
  /// False, and the message untouched: no room for it.
  bool add(Message& message);

  /// Hands over all that waits; what comes meanwhile waits for the next time.
  template <class Call>
  void drain(Call call) {
    begin_drain();
    for (Waiting& one : leaving_) {
      if (one.dropped) continue;
      call(one.message);
      one.message.body = model::KeepAlive{};  // of 45,000 joins, what follows from each finds the room of the last one
    }
    end_drain();
  }

  Gateway::Counters counters;
  std::uint64_t reported_drops = 0;  ///< how many dropped readings the log was told

 private:
  struct Waiting {
    explicit Waiting(Message&& waiting) : message(std::move(waiting)) {}
    Message message;
    bool dropped = false;
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  /// Where a device's Join and KeepAlive stand.
  struct Marks {
    std::size_t join = kNone;
    std::size_t keep_alive = kNone;
  };

  bool add_updates(Message& message);
  bool add_join(Message& message);
  bool add_keep_alive(Message& message);
  bool add_other(Message& message);
  void push(Message& message) { waiting_.emplace_back(std::move(message)); }
  Marks* marks_of(const std::string& device);
  void drop_oldest_updates();
  void close_ranks();
  void begin_drain();
  void end_drain();

  std::string network_;
  GatewayLimits limits_;
  std::vector<Waiting> waiting_, leaving_;
  std::unordered_map<std::string, Marks> marks_;
  std::size_t readings_ = 0;  ///< waiting; a message without any counts as one
  std::size_t others_ = 0;
  std::size_t oldest_ = 0;   ///< no Updates wait before this place
  std::size_t dropped_ = 0;  ///< places of dropped messages
};

}  // namespace rubicon::gateway
