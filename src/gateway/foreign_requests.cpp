#include "gateway/foreign_requests.h"

namespace rubicon::gateway {

namespace {

constexpr std::size_t kMaxOpen = 10000;

const std::uint64_t* request_in(const model::Body& body) {
  if (const auto* actuate = std::get_if<model::Actuate>(&body)) return &actuate->request;
  if (const auto* sample = std::get_if<model::Sample>(&body)) return &sample->request;
  if (const auto* property = std::get_if<model::SetProperty>(&body)) return &property->request;
  return nullptr;
}

void set_request(model::Body& body, std::uint64_t request) {
  if (auto* actuate = std::get_if<model::Actuate>(&body)) actuate->request = request;
  if (auto* sample = std::get_if<model::Sample>(&body)) sample->request = request;
  if (auto* property = std::get_if<model::SetProperty>(&body)) property->request = request;
}

}  // namespace

std::uint64_t request_of(const Message& message) {
  const auto* request = request_in(message.body);
  return request ? *request : message.number;
}

void ForeignRequests::translate(Message& message) {
  const auto* request = request_in(message.body);
  if (!request) return;
  open_.emplace(++last_, Asker{message.source, *request});
  order_.push_back(last_);
  set_request(message.body, last_);
  if (order_.size() <= kMaxOpen) return;
  open_.erase(order_.front());
  order_.pop_front();
}

std::optional<ForeignRequests::Asker> ForeignRequests::asker(std::uint64_t request) {
  const auto found = open_.find(request);
  if (found == open_.end()) return std::nullopt;
  auto asker = std::move(found->second);
  open_.erase(found);
  return asker;
}

}  // namespace rubicon::gateway
