#include "gateway/inbox.h"

#include <algorithm>
#include <utility>

namespace rubicon::gateway {

namespace {

/// More capacity than this is freed when the load that needed it is over.
constexpr std::size_t kCapacityKept = 1024;

std::size_t weight(const model::Updates& updates) {
  return std::max<std::size_t>(1, updates.readings.size());
}

/// A later Join or KeepAlive of the device must not replace one from before this message.
bool ends_presence(const Message& message) {
  return message.kind() == MessageKind::kLeave || message.kind() == MessageKind::kUnreachable;
}

}  // namespace

bool Inbox::add(Message& message) {
  switch (message.kind()) {
    case MessageKind::kUpdates: return add_updates(message);
    case MessageKind::kJoin: return add_join(message);
    case MessageKind::kKeepAlive: return add_keep_alive(message);
    default: return add_other(message);
  }
}

bool Inbox::add_updates(Message& message) {
  readings_ += weight(*std::get_if<model::Updates>(&message.body));
  push(message);
  while (readings_ > limits_.queue) drop_oldest_updates();
  return true;
}

void Inbox::drop_oldest_updates() {
  while (waiting_[oldest_].dropped || waiting_[oldest_].message.kind() != MessageKind::kUpdates) ++oldest_;
  Waiting& oldest = waiting_[oldest_];
  const auto& updates = *std::get_if<model::Updates>(&oldest.message.body);
  counters.dropped_readings += updates.readings.size();
  readings_ -= weight(updates);
  oldest.message.body = model::KeepAlive{};
  oldest.dropped = true;
  if (++dropped_ > kCapacityKept + limits_.queue / 2) compact();
}

/// nullptr: there is no room for another device.
Inbox::Marks* Inbox::marks_of(const std::string& device) {
  if (const auto found = marks_.find(device); found != marks_.end()) return &found->second;
  if (marks_.size() >= limits_.devices) return nullptr;
  return &marks_[device];
}

bool Inbox::add_join(Message& message) {
  Marks* marks = marks_of(message.source.device);
  if (marks == nullptr) return false;
  if (marks->join != kNone) {
    waiting_[marks->join].message = std::move(message);
    return true;
  }
  marks->join = waiting_.size();
  push(message);
  return true;
}

bool Inbox::add_keep_alive(Message& message) {
  Marks* marks = marks_of(message.source.device);
  if (marks == nullptr) return false;
  if (marks->keep_alive != kNone) return true;
  marks->keep_alive = waiting_.size();
  push(message);
  return true;
}

bool Inbox::add_other(Message& message) {
  if (others_ >= limits_.queue) return false;
  ++others_;
  if (ends_presence(message)) marks_.erase(message.source.device);
  push(message);
  return true;
}

void Inbox::compact() {
  std::erase_if(waiting_, [](const Waiting& one) { return one.dropped; });
  oldest_ = dropped_ = 0;
  marks_.clear();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const Message& message = waiting_[i].message;
    if (ends_presence(message)) marks_.erase(message.source.device);
    if (message.kind() == MessageKind::kJoin) marks_[message.source.device].join = i;
    if (message.kind() == MessageKind::kKeepAlive) marks_[message.source.device].keep_alive = i;
  }
}

void Inbox::begin_drain() {
  leaving_.swap(waiting_);
  if (!marks_.empty()) marks_.clear();
  readings_ = others_ = oldest_ = dropped_ = 0;
}

void Inbox::end_drain() {
  const std::size_t used = leaving_.size();
  leaving_.clear();
  if (leaving_.capacity() > std::max(kCapacityKept, used * 4)) leaving_.shrink_to_fit();
}

}  // namespace rubicon::gateway
