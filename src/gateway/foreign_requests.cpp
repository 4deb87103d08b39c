#include "gateway/foreign_requests.h"

namespace rubicon::gateway {

namespace {

constexpr std::uint64_t kOurs = std::uint64_t{1} << 63;

}  // namespace

std::uint64_t* request_of(Message& message) {
  if (auto* actuate = std::get_if<model::Actuate>(&message.body)) return &actuate->request;
  if (auto* sample = std::get_if<model::Sample>(&message.body)) return &sample->request;
  if (auto* set = std::get_if<model::SetProperty>(&message.body)) return &set->request;
  return nullptr;
}

std::uint64_t answerable_number(const Message& message) {
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) return actuate->request;
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) return sample->request;
  if (const auto* set = std::get_if<model::SetProperty>(&message.body)) return set->request;
  return message.number;
}

void ForeignRequests::lend(Message& message, SteadyTime now) {
  std::uint64_t* request = request_of(message);
  if (request == nullptr) return;
  while (!askers_.empty() && (askers_.size() >= kLimit || now - askers_.begin()->second.since > kLongestWait))
    askers_.erase(askers_.begin());
  askers_[++last_] = {message.source, *request, now};
  *request = last_;
}

bool ForeignRequests::give_back(Message& answer) {
  auto* acknowledge = std::get_if<model::Acknowledge>(&answer.body);
  if (acknowledge == nullptr || acknowledge->request < kOurs) return false;
  const auto found = askers_.find(acknowledge->request);
  if (found == askers_.end()) return true;
  acknowledge->request = found->second.request;
  answer.destination = std::move(found->second.address);
  askers_.erase(found);
  return true;
}

}  // namespace rubicon::gateway
