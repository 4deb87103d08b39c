#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "transport/mqtt.h"

namespace rubicon::networks::zigbee {

/// State messages between the line and the devices. The bridge repeats the states of all devices when it starts
/// (zigbee.md, section 1); they are taken in turns of a few milliseconds, so that the loop serves others between them.
class Arrivals {
 public:
  static constexpr std::size_t kMaxMessages = 20'000, kMaxBytes = std::size_t{16} << 20;
  static constexpr Duration kTurn = std::chrono::milliseconds(2);

  struct Callbacks {
    /// Gets each message, in order, in a later turn; may destroy this.
    std::function<void(const transport::MqttMessage& message)> take;
    /// Whether a later message of the topic repeats what this one has.
    std::function<bool(const transport::MqttMessage& message)> replaceable;
  };
  Arrivals(Scheduler& scheduler, Callbacks calls);

  /// Beyond the bounds the oldest messages that later ones replace are dropped; beyond twice the bounds the oldest of
  /// all.
  void add(const transport::MqttMessage& message);
  /// Takes all that wait, in this turn: what follows them changes what they mean.
  void drain();
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Waiting {
    std::string topic, payload;
    bool retained = false;
    transport::MqttMessage message() const { return {topic, payload, retained}; }
    std::size_t size() const { return topic.size() + payload.size(); }
  };
  /// Messages and their bytes.
  struct Load {
    std::size_t messages = 0, bytes = 0;
    bool exceeds(const Load& limit) const { return messages > limit.messages || bytes > limit.bytes; }
  };
  void run();
  void take_first();
  Load load() const { return {waiting_.size(), bytes_}; }
  std::vector<bool> find_replaced() const;
  void drop_replaced();
  void drop_oldest();

  Scheduler& scheduler_;
  Callbacks callbacks_;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  Load next_look_{kMaxMessages, kMaxBytes};  ///< beyond it, replaced messages are looked for
  std::uint64_t dropped_ = 0;
  base::OncePerTurn turn_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::zigbee
