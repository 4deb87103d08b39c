#include "networks/zigbee/arrivals.h"

#include <algorithm>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace rubicon::networks::zigbee {

namespace {

/// Between two looks at the clock; some 15 us each.
constexpr int kMessagesPerLook = 16;
constexpr int kMessagesPerTurn = 512;  ///< also where time stands still

}  // namespace

Arrivals::Arrivals(Scheduler& scheduler, Callbacks calls)
    : scheduler_(scheduler), callbacks_(std::move(calls)), turn_(scheduler, [this] { run(); }) {}

void Arrivals::add(const transport::MqttMessage& message) {
  if (waiting_.empty()) next_look_ = {kMaxMessages, kMaxBytes};
  Waiting waiting{std::string(message.topic), std::string(message.payload), message.retained};
  bytes_ += waiting.size();
  waiting_.push_back(std::move(waiting));
  if (load().exceeds(next_look_)) drop_replaced();
  while (load().exceeds({2 * kMaxMessages, 2 * kMaxBytes}) && waiting_.size() > 1) drop_oldest();
  turn_.request();
}

std::vector<bool> Arrivals::find_replaced() const {
  std::unordered_set<std::string_view> later;
  std::vector<bool> replaced(waiting_.size());
  for (auto i = waiting_.size(); i-- > 0;) {
    const auto message = waiting_[i].message();
    replaced[i] = callbacks_.replaceable(message) && !later.insert(message.topic).second;
  }
  return replaced;
}

/// Makes room for a quarter of the bounds, so that a burst rarely searches the whole queue.
void Arrivals::drop_replaced() {
  const auto replaced = find_replaced();
  auto left = load();
  std::deque<Waiting> kept;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (replaced[i] && left.exceeds({kMaxMessages / 4 * 3, kMaxBytes / 4 * 3})) {
      --left.messages;
      left.bytes -= waiting_[i].size();
    } else {
      kept.push_back(std::move(waiting_[i]));
    }
  }
  dropped_ += waiting_.size() - kept.size();
  waiting_ = std::move(kept);
  bytes_ = left.bytes;
  next_look_ = {std::max(kMaxMessages, left.messages + kMaxMessages / 4),
                std::max(kMaxBytes, left.bytes + kMaxBytes / 4)};
}

void Arrivals::drop_oldest() {
  bytes_ -= waiting_.front().size();
  waiting_.pop_front();
  ++dropped_;
}

void Arrivals::drain() {
  const auto watch = lifetime_.watch();
  while (!watch.ended() && !waiting_.empty()) take_first();
}

void Arrivals::take_first() {
  const auto message = std::move(waiting_.front());
  waiting_.pop_front();
  bytes_ -= message.size();
  callbacks_.take(message.message());
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
