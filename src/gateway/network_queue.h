#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gateway/gateway.h"

namespace rubicon::gateway {

/// The messages of one network that wait for the next turn, in order and bounded: of readings the oldest are dropped,
/// of joins and KeepAlives the latest per device is kept, others are refused once there is no room. The
/// bytes of the texts of readings and of others are bounded too; those of a join are not: its network holds them
/// anyway.
class NetworkQueue {
 public:
  /// Of the texts of readings, and of those of others.
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20;

  NetworkQueue(std::string network, GatewayLimits limits) : network_(std::move(network)), limits_(limits) {}

  void limit(GatewayLimits limits) { limits_ = limits; }
  const std::string& network() const { return network_; }
  /// False if there is no room: the message is unchanged.
  bool add(Message& message);

  /// Calls with each waiting message, and before that `next` with some that come next. Those that arrive meanwhile wait
  /// for the next time.
  template <class Call>
  void drain(const Gateway::NextCall& next, Call call) {
    begin_drain();
    for (std::size_t i = 0; i < leaving_.size(); ++i) {
      if (next && i % kAhead == 0)
        next(std::span<const Message>(leaving_).subspan(i, std::min(kAhead, leaving_.size() - i)));
      auto& message = leaving_[i];
      if (is_dropped(message)) continue;
      call(message);
      message.body = model::KeepAlive{};  // frees the memory of each join before the next one needs some
    }
    end_drain();
  }

  Gateway::Counters counters;
  std::uint64_t reported_drops = 0;  ///< dropped readings that were logged

 private:
  /// As many as a processor fetches memory for at the same time.
  static constexpr std::size_t kAhead = 16;
  /// A message that waits has an origin.
  static bool is_dropped(const Message& message) { return message.origin == model::kNoOwner; }
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
  std::vector<Message> waiting_, leaving_;
  std::unordered_map<std::string, Marks> marks_;
  std::size_t readings_ = 0;  ///< waiting; a message without any counts as one
  std::size_t others_ = 0;
  std::size_t reading_bytes_ = 0, other_bytes_ = 0;
  std::size_t oldest_ = 0;   ///< no Updates wait before this position
  std::size_t dropped_ = 0;  ///< positions of dropped messages
};

/// The subscribers to one kind of message. They may subscribe and unsubscribe, themselves included, during a call.
class Listeners {
 public:
  [[nodiscard]] Handle add(MessageCall call);
  /// Returns how many listeners were called.
  std::size_t call(const Message& message);
  bool empty() const { return content_->listeners.empty(); }

 private:
  struct Listener {
    MessageCall call;
    bool ended = false;
  };
  /// Shared with the handles, which may outlive the gateway.
  struct Content {
    std::vector<std::shared_ptr<Listener>> listeners;
    int depth = 0;
    bool untidy = false;
    void end(const Listener* listener);
    void tidy();
  };
  std::shared_ptr<Content> content_ = std::make_shared<Content>();
};

}  // namespace rubicon::gateway
