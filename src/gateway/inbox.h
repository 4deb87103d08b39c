#pragma once

#include <limits>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gateway/gateway.h"

namespace rubicon::gateway {

/// The messages of one network that wait for the next turn, in order and bounded: of readings the oldest are dropped,
/// of joins and KeepAlives the latest per device is kept, others are refused once there is no room.
class Inbox {
 public:
  Inbox(std::string network, GatewayLimits limits) : network_(std::move(network)), limits_(limits) {}

  void limit(GatewayLimits limits) { limits_ = limits; }
  const std::string& network() const { return network_; }
  /// False if there is no room: the message is unchanged.
  bool add(Message& message);

  /// Calls with each waiting message. Those that arrive meanwhile wait for the next time.
  template <class Call>
  void drain(Call call) {
    begin_drain();
    for (Waiting& one : leaving_) {
      if (one.dropped) continue;
      call(one.message);
      one.message.body = model::KeepAlive{};  // frees the memory of each join before the next one needs some
    }
    end_drain();
  }

  Gateway::Counters counters;
  std::uint64_t reported_drops = 0;  ///< dropped readings that were logged

 private:
  struct Waiting {
    explicit Waiting(Message&& waiting) : message(std::move(waiting)) {}
    Message message;
    bool dropped = false;
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  /// Positions of the Join and the KeepAlive of a device.
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
  void compact();
  void begin_drain();
  void end_drain();

  std::string network_;
  GatewayLimits limits_;
  std::vector<Waiting> waiting_, leaving_;
  std::unordered_map<std::string, Marks> marks_;
  std::size_t readings_ = 0;  ///< waiting; a message without any counts as one
  std::size_t others_ = 0;
  std::size_t oldest_ = 0;   ///< no Updates wait before this position
  std::size_t dropped_ = 0;  ///< positions of dropped messages
};

}  // namespace rubicon::gateway
