#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "transport/mqtt.h"

namespace rubicon::networks::zigbee {

/// State messages between the line and the devices. The bridge repeats the states of all devices when it starts
/// (zigbee.md, section 1); they are taken in turns of a few milliseconds, so that the loop serves others between them.
class Arrivals {
 public:
  static constexpr std::size_t kMaxMessages = 20'000, kMaxBytes = std::size_t{16} << 20;
  static constexpr Duration kTurn = std::chrono::milliseconds(2);

  /// `take` gets each message, in order, in a later turn; it may destroy this.
  Arrivals(Scheduler& scheduler, std::function<void(const transport::MqttMessage& message)> take);

  /// Beyond the bounds the oldest message is dropped: a later one of its device repeats the values.
  void add(const transport::MqttMessage& message);
  /// Takes all that wait, in this turn: what follows them changes what they mean.
  void drain();
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Waiting {
    std::string topic, payload;
    bool retained = false;
    std::size_t size() const { return topic.size() + payload.size(); }
  };
  void run();
  void take_first();

  Scheduler& scheduler_;
  std::function<void(const transport::MqttMessage& message)> take_;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  std::uint64_t dropped_ = 0;
  base::OncePerTurn turn_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::zigbee
