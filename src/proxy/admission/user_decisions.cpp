#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "model/point_keys.h"
#include "proxy/admission/admission.h"
#include "rubicon/key.hpp"
#include "tuples/space_rights.h"

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

/// kInvalid: the text is neither `approve` nor `ignore`, or lacks the pattern.
Result<Admission::Order> Admission::read_order(const tuples::RemoteSet& request, const std::string& root) {
  const bool many = request.key == root;
  const std::string_view text = request.value;
  const auto blank = many ? text.find(' ') : text.npos;
  const auto decision = decision_of(text.substr(0, blank));
  if (!decision || (many && (blank == text.npos || blank + 1 == text.size()))) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected {}, got {}", model::quoted(request.key),
                            many ? "approve or ignore and a pattern such as wsn-1.*" : "approve or ignore",
                            model::quoted(text)));
  }
  return Order{*decision, std::string(text.substr(0, blank)), many,
               std::string(many ? text.substr(blank + 1) : std::string_view(request.key).substr(root.size() + 1))};
}

/// `approve` on `proxy.inbox.wsn-1.7`, or `approve wsn-1.*` on `proxy.inbox`.
tuples::SetDecision Admission::decide_set(const tuples::RemoteSet& request) {
  const auto order = read_order(request, model::IslandKey{context_.config.prefix}.inbox());
  if (!order) return tuples::SetDecision::refused(order.error());
  auto found = devices_of(*order);
  if (!found) return tuples::SetDecision::refused(found.error());
  auto left_out = drop_denied(request, *found);
  if (!left_out) return tuples::SetDecision::refused(left_out.error());
  if (decisions_.size() + found->size() > 2 * context_.config.max_devices)
    return tuples::SetDecision::refused({ErrorCode::kBusy, "too many decisions at once, try again"});
  for (auto& name : *found) decisions_.emplace_back(std::move(name), order->decision);
  next_decisions_.request();
  auto decision = tuples::SetDecision::consumed();
  decision.text = std::move(*left_out);
  return decision;
}

/// By its key in the inbox, by that of its address, and by that of its tuples.
std::vector<std::string> Admission::inbox_keys(const DeviceName& name) {
  const model::IslandKey island{context_.config.prefix};
  std::vector<std::string> keys{island.inbox(key_of(name))};
  if (const auto* entry = inbox_.find(name)) {
    for (const auto& key : {entry->key, entry->hidden_key}) {
      if (!key.empty()) keys.push_back(island.inbox(key));
    }
  }
  if (const auto parts = directory_.parts_of(name.network, name.address); !parts.empty())
    keys.push_back(island.inbox(parts));
  return keys;
}

/// Drops devices that an exception of the rules keeps from who decides. Returns what the answer says of them; kRefused:
/// nothing is left.
Result<std::string> Admission::drop_denied(const tuples::RemoteSet& request, std::vector<DeviceName>& devices) {
  const auto* judge = tuples::SpaceRights::judge(context_.space);
  const auto* who = tuples::SpaceRights::asker(context_.space, request);
  if (!judge || !who) return std::string();
  const auto before = devices.size();
  std::optional<Error> why;
  std::erase_if(devices, [&](const DeviceName& name) {
    auto may = judge->may_by_names(*who, tuples::Act::kSet, inbox_keys(name));
    if (!may && !why) why = std::move(may.error());
    return !may;
  });
  if (!why) return std::string();
  if (devices.empty()) return fail(std::move(*why));
  return fmt::format("{} of {} devices left out: {}", before - devices.size(), before, why->text);
}

/// What a name without wildcards means: the device that waits, an ignored one, or, to be ignored, a listed one.
/// Patterns mean only devices that wait.
std::vector<DeviceName> Admission::named(const Order& order) {
  auto found = inbox_.with_key(order.pattern);
  if (!found.empty() || order.decision != Decision::kIgnored) return found;
  const auto dot = order.pattern.find('.');
  const auto network = order.pattern.substr(0, dot);
  const auto* device = directory_.find_by_key(order.pattern);
  if (!device && dot != order.pattern.npos && directory_.networks().contains(network))
    device = directory_.find(directory_.network(network), order.pattern.substr(dot + 1));
  if (device) found.push_back({device->network->id, device->address});
  return found;
}

/// kNotFound: none; kDuplicate: one is meant and several fit; kRefused: none of them can be approved.
Result<std::vector<DeviceName>> Admission::devices_of(const Order& order) {
  const bool is_pattern = order.many && order.pattern.find_first_of("*?") != order.pattern.npos;
  auto found = order.many ? inbox_.matching(order.pattern) : std::vector<DeviceName>();
  if (found.empty() && !is_pattern) found = named(order);
  if (found.size() > 1 && !is_pattern) {
    return fail(ErrorCode::kDuplicate,
                fmt::format("{} fits {} devices: set {} to {} {}.<address>", model::quoted(order.pattern), found.size(),
                            model::IslandKey{context_.config.prefix}.inbox(), order.word, found.front().network));
  }
  if (found.empty()) return fail(ErrorCode::kNotFound, fmt::format("no device {} waits", model::quoted(order.pattern)));
  if (order.decision != Decision::kApproved) return found;
  const auto first = found.front();
  std::erase_if(found, [this](const DeviceName& name) { return inbox_.find(name)->state == InboxState::kUnusable; });
  if (found.empty())
    return fail(ErrorCode::kRefused, fmt::format("{} cannot be used: {}", key_of(first), inbox_.find(first)->why));
  return found;
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
    memory_.end_decision(name.network, name.address, join);
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
