#include "gateway/network_queue.h"

#include <algorithm>
#include <utility>

namespace rubicon::gateway {

namespace {

/// More capacity than this is freed when the load that needed it is over.
constexpr std::size_t kCapacityKept = 1024;

std::size_t weight(const model::Updates& updates) {
  return std::max<std::size_t>(1, updates.readings.size());
}

std::size_t bytes_of(const model::Updates& updates) {
  std::size_t bytes = 0;
  for (const auto& reading : updates.readings) {
    if (const auto* text = std::get_if<std::string>(&reading.value)) bytes += text->size();
    if (const auto* json = std::get_if<model::Json>(&reading.value)) bytes += json->text.size();
    bytes += reading.why.size();
  }
  return bytes;
}

/// Of what is neither a reading nor a join; its other texts are short.
std::size_t bytes_of_other(const Message& message) {
  std::size_t bytes = 0;
  if (const auto* opaque = std::get_if<model::Opaque>(&message.body)) bytes += opaque->bytes.size();
  if (const auto* state = std::get_if<model::State>(&message.body)) {
    for (const auto& [name, text] : state->texts) bytes += text.size();
  }
  return bytes;
}

/// A later Join or KeepAlive of the device must not replace one from before this message.
bool ends_presence(const Message& message) {
  return message.kind() == MessageKind::kLeave || message.kind() == MessageKind::kUnreachable;
}

}  // namespace

bool NetworkQueue::add(Message& message) {
  switch (message.kind()) {
    case MessageKind::kUpdates: return add_updates(message);
    case MessageKind::kJoin: return add_join(message);
    case MessageKind::kKeepAlive: return add_keep_alive(message);
    default: return add_other(message);
  }
}

bool NetworkQueue::add_updates(Message& message) {
  const auto& updates = *std::get_if<model::Updates>(&message.body);
  readings_ += weight(updates);
  reading_bytes_ += bytes_of(updates);
  push(message);
  while (readings_ > limits_.queue || reading_bytes_ > kMaxBytes) drop_oldest_updates();
  return true;
}

void NetworkQueue::drop_oldest_updates() {
  while (waiting_[oldest_].kind() != MessageKind::kUpdates) ++oldest_;
  Message& oldest = waiting_[oldest_];
  const auto& updates = *std::get_if<model::Updates>(&oldest.body);
  counters.dropped_readings += updates.readings.size();
  readings_ -= weight(updates);
  reading_bytes_ -= bytes_of(updates);
  oldest.body = model::KeepAlive{};
  oldest.origin = model::kNoOwner;
  if (++dropped_ > kCapacityKept + limits_.queue / 2) compact();
}

/// nullptr: there is no room for another device.
NetworkQueue::Marks* NetworkQueue::marks_of(const std::string& device) {
  if (const auto found = marks_.find(device); found != marks_.end()) return &found->second;
  if (marks_.size() >= limits_.devices) return nullptr;
  return &marks_[device];
}

bool NetworkQueue::add_join(Message& message) {
  Marks* marks = marks_of(message.source.device);
  if (marks == nullptr) return false;
  if (marks->join != kNone) {
    waiting_[marks->join] = std::move(message);
    return true;
  }
  marks->join = waiting_.size();
  push(message);
  return true;
}

bool NetworkQueue::add_keep_alive(Message& message) {
  Marks* marks = marks_of(message.source.device);
  if (marks == nullptr) return false;
  if (marks->keep_alive != kNone) return true;
  marks->keep_alive = waiting_.size();
  push(message);
  return true;
}

bool NetworkQueue::add_other(Message& message) {
  const auto bytes = bytes_of_other(message);
  if (others_ >= limits_.queue || other_bytes_ + bytes > kMaxBytes) return false;
  ++others_;
  other_bytes_ += bytes;
  if (ends_presence(message)) marks_.erase(message.source.device);
  push(message);
  return true;
}

void NetworkQueue::compact() {
  std::erase_if(waiting_, is_dropped);
  oldest_ = dropped_ = 0;
  marks_.clear();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const Message& message = waiting_[i];
    if (ends_presence(message)) marks_.erase(message.source.device);
    if (message.kind() == MessageKind::kJoin) marks_[message.source.device].join = i;
    if (message.kind() == MessageKind::kKeepAlive) marks_[message.source.device].keep_alive = i;
  }
}

void NetworkQueue::begin_drain() {
  leaving_.swap(waiting_);
  if (!marks_.empty()) marks_.clear();
  readings_ = others_ = oldest_ = dropped_ = 0;
  reading_bytes_ = other_bytes_ = 0;
}

void NetworkQueue::end_drain() {
  const std::size_t used = leaving_.size();
  leaving_.clear();
  if (leaving_.capacity() > std::max(kCapacityKept, used * 4)) leaving_.shrink_to_fit();
}

Handle Listeners::add(MessageCall call) {
  auto listener = std::make_shared<Listener>(Listener{std::move(call)});
  content_->listeners.push_back(listener);
  return Handle([content = std::weak_ptr<Content>(content_), gone = std::weak_ptr<Listener>(listener)] {
    const auto still = gone.lock();
    if (const auto all = content.lock(); all && still) all->end(still.get());
  });
}

void Listeners::Content::end(const Listener* listener) {
  for (const auto& one : listeners) {
    if (one.get() == listener) one->ended = untidy = true;
  }
  if (depth == 0) tidy();
}

void Listeners::Content::tidy() {
  if (std::exchange(untidy, false)) std::erase_if(listeners, [](const auto& one) { return one->ended; });
}

std::size_t Listeners::call(const Message& message) {
  Content& content = *content_;
  std::size_t heard = 0;
  ++content.depth;
  for (std::size_t i = 0, count = content.listeners.size(); i < count; ++i) {
    Listener& listener = *content.listeners[i];
    if (listener.ended) continue;
    listener.call(message);
    ++heard;
  }
  if (--content.depth == 0) content.tidy();
  return heard;
}

}  // namespace rubicon::gateway
