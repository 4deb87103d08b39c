#include "gateway/inbox.h"

namespace rubicon::gateway {

bool Inbox::put(Message& message) {
  switch (message.kind()) {
    case MessageKind::kUpdates:
      return put_updates(message, std::get<model::Updates>(message.body).readings.size());
    case MessageKind::kJoin: return put_join(message);
    case MessageKind::kKeepAlive:
      if (alive_.contains(message.source.device)) return true;
      if (!put_other(message)) return true;  // one sign of life less: the next one counts as well
      alive_.emplace(at(first_ + queue_.size() - 1).message.source.device, first_ + queue_.size() - 1);
      return true;
    case MessageKind::kLeave:
      joins_.erase(message.source.device);  // what joins later is another life of the device
      alive_.erase(message.source.device);
      return put_other(message);
    default: return put_other(message);
  }
}

std::uint64_t Inbox::append(Message& message) {
  queue_.push_back({std::move(message), false});
  return first_ + queue_.size() - 1;
}

bool Inbox::put_updates(Message& message, std::size_t readings) {
  readings_ += readings;
  updates_.push_back(append(message));
  while (readings_ > limits_.queue && updates_.size() > 1) drop_oldest_readings();
  return true;
}

void Inbox::drop_oldest_readings() {
  auto& oldest = at(updates_.front());
  updates_.pop_front();
  const auto readings = std::get<model::Updates>(oldest.message.body).readings.size();
  readings_ -= readings;
  counters.dropped_readings += readings;
  oldest.message = Message{};
  oldest.dropped = true;
}

bool Inbox::put_join(Message& message) {
  const auto found = joins_.find(message.source.device);
  if (found != joins_.end()) {
    at(found->second).message = std::move(message);
    return true;
  }
  if (joins_.size() >= limits_.devices) {
    ++counters.refused_busy;
    return false;
  }
  const auto position = append(message);
  joins_.emplace(at(position).message.source.device, position);
  return true;
}

bool Inbox::put_other(Message& message) {
  if (others_ >= limits_.queue) {
    ++counters.refused_busy;
    return false;
  }
  ++others_;
  append(message);
  return true;
}

bool Inbox::take(Message& into) {
  while (!queue_.empty()) {
    const bool dropped = queue_.front().dropped;
    if (!dropped) into = std::move(queue_.front().message);
    queue_.pop_front();
    const auto position = first_++;
    if (dropped) continue;
    if (const auto* updates = std::get_if<model::Updates>(&into.body)) {
      readings_ -= updates->readings.size();
      updates_.pop_front();
      return true;
    }
    if (into.kind() == MessageKind::kJoin) {
      const auto found = joins_.find(into.source.device);
      if (found != joins_.end() && found->second == position) joins_.erase(found);
      return true;
    }
    if (into.kind() == MessageKind::kKeepAlive) alive_.erase(into.source.device);
    --others_;
    return true;
  }
  return false;
}

}  // namespace rubicon::gateway
