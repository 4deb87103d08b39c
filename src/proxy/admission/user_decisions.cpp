#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>

#include "model/point_keys.h"
#include "proxy/admission/admission.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy::admission {

// What users decide about devices of the inbox.

namespace {

using state::Decision;

/// Decisions carried out in one turn of the loop.
constexpr std::size_t kDecisionsATurn = 200;

std::optional<Decision> decision_of(std::string_view word) {
  if (word == "approve") return Decision::kApproved;
  if (word == "ignore") return Decision::kIgnored;
  return std::nullopt;
}

}  // namespace

/// `approve` on `proxy.inbox.wsn-1.7`, or `approve wsn-1.*` on `proxy.inbox`.
tuples::SetDecision Admission::decide_set(const tuples::RemoteSet& request) {
  const auto root = model::IslandKey{context_.config.prefix}.inbox();
  const bool many = request.key == root;
  const std::string_view text = request.value;
  const auto blank = many ? text.find(' ') : text.npos;
  const auto decision = decision_of(text.substr(0, blank));
  if (!decision || (many && (blank == text.npos || blank + 1 == text.size()))) {
    return tuples::SetDecision::refused(
        {ErrorCode::kInvalid,
         fmt::format("{}: expected {}, got {}", model::quoted(request.key),
                     many ? "approve or ignore and a pattern such as wsn-1.*" : "approve or ignore",
                     model::quoted(text))});
  }
  const std::string pattern = many ? std::string(text.substr(blank + 1)) : request.key.substr(root.size() + 1);
  auto found = many ? inbox_.matching(pattern) : inbox_.with_key(pattern);
  if (found.size() > 1 && !many) {
    return tuples::SetDecision::refused(
        {ErrorCode::kDuplicate, fmt::format("{} fits {} devices: set {} to {} {}.<address>", model::quoted(pattern),
                                            found.size(), root, text, found.front().network)});
  }
  if (found.empty() && !many && *decision == Decision::kIgnored) {
    if (const auto* device = directory_.find_by_key(pattern)) found.push_back({device->network->id, device->address});
  }
  if (found.empty()) {
    return tuples::SetDecision::refused(
        {ErrorCode::kNotFound, fmt::format("no device {} waits", model::quoted(pattern))});
  }
  if (*decision == Decision::kApproved) {
    const auto usable = [this](const DeviceName& name) { return inbox_.find(name)->state != InboxState::kUnusable; };
    const auto first = found.front();
    std::erase_if(found, std::not_fn(usable));
    if (found.empty()) {
      return tuples::SetDecision::refused(
          {ErrorCode::kRefused, fmt::format("{} cannot be used: {}", key_of(first), inbox_.find(first)->why)});
    }
  }
  if (decisions_.size() + found.size() > 2 * context_.config.max_devices)
    return tuples::SetDecision::refused({ErrorCode::kBusy, "too many decisions at once, try again"});
  for (auto& name : found) decisions_.emplace_back(std::move(name), *decision);
  next_decisions_.request();
  return tuples::SetDecision::consumed();
}

void Admission::apply_decisions() {
  context_.clock.refresh();
  const auto end = decisions_.begin() + static_cast<std::ptrdiff_t>(std::min(decisions_.size(), kDecisionsATurn));
  const std::vector slice(std::move_iterator(decisions_.begin()), std::move_iterator(end));
  decisions_.erase(decisions_.begin(), end);
  for (const auto& [name, decision] : slice) decision == Decision::kApproved ? approve(name) : ignore(name);
  if (!decisions_.empty()) next_decisions_.request();
}

void Admission::approve(const DeviceName& name) {
  const auto* entry = inbox_.find(name);
  if (!entry) return;
  const auto announced = entry->announced;
  const auto& join = announced.join;
  if (!join.problem.empty()) {  // was ignored, or became unusable since
    memory_.forget(name.network, name.address);
    inbox_.put(name, announced, InboxState::kUnusable, join.problem);
    return;
  }
  context_.log.info(fmt::format("{} was approved", key_of(name)));
  if (auto* device = retry(directory_.network(name.network), name, true)) {
    memory_.approved(*device);
  } else {
    memory_.save_unlisted(name.network, name.address, join, Decision::kApproved);
  }
}

void Admission::ignore(const DeviceName& name) {
  Announced announced;
  if (const auto* entry = inbox_.find(name)) announced = entry->announced;
  if (auto* device = directory_.find(directory_.network(name.network), name.address)) {
    announced = last_announcement(*device);
    callbacks_.ignored(*device);
  }
  roaming_.forget(name);
  context_.log.info(fmt::format("{} is ignored from now on", key_of(name)));
  inbox_.put(name, announced, InboxState::kIgnoredByUser, std::string(kDecidedByUser));
  memory_.save_unlisted(name.network, name.address, announced.join, Decision::kIgnored);
}

}  // namespace rubicon::proxy::admission
