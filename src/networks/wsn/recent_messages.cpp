#include "networks/wsn/recent_messages.h"

#include <algorithm>

namespace rubicon::networks::wsn {

namespace {

/// DEMO_DATA of the released firmware and UPDATES of the Control module (wsn.md 7.1).
bool is_report(const motes::NetMessage& message) {
  constexpr std::uint8_t kDemoData = 34, kUpdates = 35;
  return message.transport == motes::kTransportConnectionless &&
         (message.record.front() == kDemoData || message.record.front() == kUpdates);
}

}  // namespace

bool RecentMessages::seen(const motes::NetMessage& message, SteadyTime now) {
  while (!messages_.empty() && (messages_.size() >= kMaxMessages || messages_.front().first + kSpan < now))
    messages_.pop_front();
  if (message.reliable != 1 && !is_report(message)) return false;
  const Key key{message.source_island, message.source_mote, message.sequence,
                message.transport,     message.application, message.record.front()};
  if (std::any_of(messages_.begin(), messages_.end(), [&](const auto& one) { return one.second == key; })) return true;
  messages_.emplace_back(now, key);
  return false;
}

void RecentMessages::forget(std::uint16_t mote) {
  std::erase_if(messages_, [mote](const auto& one) { return std::get<1>(one.second) == mote; });
}

}  // namespace rubicon::networks::wsn
