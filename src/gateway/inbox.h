#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <unordered_map>

#include "gateway/gateway.h"
#include "model/message.h"

namespace rubicon::gateway {

/// What one network delivered and nobody has heard yet: in order, and bounded. When full, the oldest readings go;
/// joins and signs of life of one device coalesce; the rest is refused.
class Inbox {
 public:
  explicit Inbox(GatewayLimits limits) : limits_(limits) {}

  /// False: refused, the message is untouched and the caller answers.
  bool put(Message& message);
  /// Takes the oldest message; false when there is none.
  bool take(Message& into);

  bool empty() const { return queue_.empty(); }
  Gateway::Counters counters;

 private:
  struct Entry {
    Message message;
    bool dropped = false;
  };
  bool put_updates(Message& message, std::size_t readings);
  bool put_join(Message& message);
  bool put_other(Message& message);
  std::uint64_t append(Message& message);
  void drop_oldest_readings();
  Entry& at(std::uint64_t position) { return queue_[static_cast<std::size_t>(position - first_)]; }

  GatewayLimits limits_;
  std::deque<Entry> queue_;
  std::uint64_t first_ = 0;                                 ///< position of the front of the queue
  std::deque<std::uint64_t> updates_;                       ///< positions of Updates not dropped
  std::unordered_map<std::string, std::uint64_t> joins_;    ///< device -> position of its last Join
  std::unordered_map<std::string, std::uint64_t> alive_;    ///< device -> position of its last KeepAlive
  std::size_t readings_ = 0, others_ = 0;
};

}  // namespace rubicon::gateway
