#include "networks/zigbee/arrivals.h"

#include <utility>

namespace rubicon::networks::zigbee {

namespace {

/// Between two looks at the clock; some 15 us each.
constexpr int kMessagesPerLook = 16;
constexpr int kMessagesPerTurn = 512;  ///< also where time stands still

}  // namespace

Arrivals::Arrivals(Scheduler& scheduler, std::function<void(const transport::MqttMessage& message)> take)
    : scheduler_(scheduler), take_(std::move(take)), turn_(scheduler, [this] { run(); }) {}

void Arrivals::add(const transport::MqttMessage& message) {
  Waiting waiting{std::string(message.topic), std::string(message.payload), message.retained};
  bytes_ += waiting.size();
  waiting_.push_back(std::move(waiting));
  while (waiting_.size() > kMaxMessages || (bytes_ > kMaxBytes && waiting_.size() > 1)) {
    bytes_ -= waiting_.front().size();
    waiting_.pop_front();
    ++dropped_;
  }
  turn_.request();
}

void Arrivals::drain() {
  const auto watch = lifetime_.watch();
  while (!watch.ended() && !waiting_.empty()) take_first();
}

void Arrivals::take_first() {
  const auto message = std::move(waiting_.front());
  waiting_.pop_front();
  bytes_ -= message.size();
  take_({message.topic, message.payload, message.retained});
}

void Arrivals::run() {
  const auto end = scheduler_.now() + kTurn;
  const auto watch = lifetime_.watch();
  for (int taken = 0; !waiting_.empty(); ++taken) {
    if (taken == kMessagesPerTurn || (taken % kMessagesPerLook == kMessagesPerLook - 1 && scheduler_.now() >= end))
      return turn_.request();
    take_first();
    if (watch.ended()) return;
  }
}

}  // namespace rubicon::networks::zigbee
