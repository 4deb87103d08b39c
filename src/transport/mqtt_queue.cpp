#include "transport/mqtt_queue.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::transport {

namespace {

std::size_t cost(const MqttPublication& publication) {
  return publication.topic.size() + publication.payload.size() + publication.response_topic.size() +
         publication.correlation.size();
}

}  // namespace

Result<void> MqttOutQueue::push(MqttPublication publication, const std::string& line) {
  const bool replaces = publication.queue == MqttQueue::kLatest;
  const auto known = replaces ? latest_.find(publication.topic) : latest_.end();
  const auto old = known == latest_.end() ? 0 : cost(waiting_[known->second - first_]);
  const auto bytes = bytes_ - old + cost(publication);
  if (bytes > MqttLine::kMaxQueuedBytes || (known == latest_.end() && waiting_.size() >= MqttLine::kMaxQueued))
    return fail(ErrorCode::kBusy, fmt::format("{}: cannot publish {} bytes: {} messages with {} bytes wait already",
                                              line, cost(publication), waiting_.size(), bytes_));
  bytes_ = bytes;
  if (known != latest_.end()) {
    waiting_[known->second - first_] = std::move(publication);
    return {};
  }
  if (!replaces) latest_.erase(publication.topic);  // a later state must not overtake it
  if (replaces) latest_[publication.topic] = first_ + waiting_.size();
  waiting_.push_back(std::move(publication));
  return {};
}

std::optional<MqttPublication> MqttOutQueue::pop() {
  if (waiting_.empty()) return std::nullopt;
  auto publication = std::move(waiting_.front());
  waiting_.pop_front();
  const auto known = latest_.find(publication.topic);
  if (known != latest_.end() && known->second == first_) latest_.erase(known);
  ++first_;
  bytes_ -= cost(publication);
  return publication;
}

}  // namespace rubicon::transport
