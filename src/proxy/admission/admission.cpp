#include "proxy/admission/admission.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "model/point_keys.h"
#include "proxy/admission/discovery_inbox.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::proxy::admission {

namespace {

using state::Decision;
using state::KnownDevice;

/// Devices that were not heard come from options or files of their network, unless it finds devices by itself.
bool comes_from_options(const Network& network, const model::Join& join) {
  return !join.heard && !network.rules.discovers;
}

bool is_configured(const Network& network, const model::Join& join) {
  return comes_from_options(network, join) || network.rules.lists_devices;
}

}  // namespace

Admission::Admission(ProxyContext& context, DeviceDirectory& directory, Memory& memory, NetworkTuples& network_tuples,
                     Callbacks callbacks)
    : context_(context),
      directory_(directory),
      memory_(memory),
      network_tuples_(network_tuples),
      callbacks_(std::move(callbacks)),
      inbox_(context),
      roaming_(context, directory,
               {callbacks_.moved, [this](const DeviceName& name) { take_over(name); }, callbacks_.unclaimed}),
      next_decisions_(context.scheduler, [this] { apply_decisions(); }) {
  inbox_.begin();
}

void Admission::on_join(const Device* device, Network& network, const std::string& address, const model::Join& join) {
  if (device == nullptr) directory_.adopt_names(network, address, join.name);
  const DeviceName name{network.id, address};
  const Announced announced{join, context_.clock.now().steady,
                            join.heard ? roaming_.join_time(network, address) : WallTime{}};
  std::optional<KnownDevice> known;
  const auto* entry = device ? nullptr : inbox_.find(name);
  // A pending device is remembered by the inbox only; others may have stored values.
  const bool remembered_here = entry && (entry->ignored() || entry->state == InboxState::kPending);
  if (!device && !remembered_here) known = memory_.recall(network.id, address);
  const auto* remembered = known ? &*known : nullptr;
  if (!device) {
    auto ruling = decide(network, name, join, remembered, comes_from_options(network, join));
    if (!ruling.is_admitted()) {
      keep_out(name, announced, remembered, std::move(ruling));
      if (join.heard) inbox_.note_message(name);
      return;
    }
  }
  list_unless_claimed(network, address, announced, remembered);
}

/// A device that cannot be used waits, unless it is ignored.
Admission::Ruling Admission::decide(const Network& network, const DeviceName& name, const model::Join& join,
                                    const KnownDevice* known, bool configured) const {
  auto ruling = decide_usable(network, name, join, known, configured);
  const bool ignored = ruling.state == InboxState::kIgnoredByRule || ruling.state == InboxState::kIgnoredByUser;
  if (join.problem.empty() || ignored) return ruling;
  return {InboxState::kUnusable, join.problem};
}

/// Ignored by a user: no. Admitted before, configured, or named in the configuration: yes. Else the rules decide.
Admission::Ruling Admission::decide_usable(const Network& network, const DeviceName& name, const model::Join& join,
                                           const KnownDevice* known, bool configured) const {
  const auto* entry = inbox_.find(name);
  if (entry && entry->state == InboxState::kUnusable) entry = nullptr;
  const bool ignored =
      entry ? entry->state == InboxState::kIgnoredByUser : known && known->decision == Decision::kIgnored;
  if (ignored) return {InboxState::kIgnoredByUser, std::string(kDecidedByUser)};
  const bool admitted_before = entry ? entry->state == InboxState::kAdmitted
                                     : known && (known->decision == Decision::kApproved || !known->id.empty());
  const bool named = names_of(network.rules, name.address) != nullptr;
  if (admitted_before || configured || roaming_.trusts(name) || named) return {};
  auto [action, why] = apply_rules(context_.config.discovery, name, join);
  switch (action) {
    case DiscoveryAction::kAuto: return {};
    case DiscoveryAction::kAsk: return {InboxState::kPending, std::move(why)};
    case DiscoveryAction::kIgnore: break;
  }
  return {InboxState::kIgnoredByRule, std::move(why)};
}

void Admission::keep_out(const DeviceName& name, const Announced& announced, const KnownDevice* known, Ruling ruling) {
  const auto put = inbox_.put(name, announced, ruling.state, std::move(ruling.why));
  const bool is_new = put == DiscoveryInbox::Put::kNew && !(known && same_announcement(known->join, announced.join));
  if (ruling.state == InboxState::kPending && is_new)
    memory_.save_unlisted(name.network, name.address, announced.join, Decision::kNone);
}

Device* Admission::list_unless_claimed(Network& network, const std::string& address, const Announced& announced,
                                       const KnownDevice* known, bool approved) {
  if (network.devices.find(address) || !roaming_.defers(network, address, announced, approved))
    return list(network, address, announced, known);
  inbox_.take({network.id, address});
  return nullptr;
}

/// nullptr: there is no room for the device, or its key is taken; it is deferred.
Device* Admission::list(Network& network, const std::string& address, const Announced& announced,
                        const KnownDevice* known) {
  const DeviceName name{network.id, address};
  const auto joined = directory_.join(network, address, announced.join);
  network_tuples_.refresh_counters();
  if (!joined) {
    defer(name, announced, joined.error().text);
    return nullptr;
  }
  inbox_.take(name);
  callbacks_.listed(*joined, announced, known);
  roaming_.publish_claim(*joined->device);
  return joined->device;
}

void Admission::defer(const DeviceName& name, const Announced& announced, const std::string& why) {
  context_.warn(name.network + "/join", why);
  inbox_.put(name, announced, InboxState::kAdmitted, why);
}

/// Lists a device of the inbox with what is remembered of it; nullptr if it still cannot be listed.
Device* Admission::retry(Network& network, const DeviceName& name, bool approved) {
  const auto announced = inbox_.find(name)->announced;
  const auto known = memory_.recall(name.network, name.address);
  return list_unless_claimed(network, name.address, announced, known ? &*known : nullptr, approved);
}

Device* Admission::on_unknown_device(Network& network, const Message& message) {
  const DeviceName name{network.id, message.source.device};
  if (inbox_.note_message(name)) {
    const auto* entry = inbox_.find(name);
    const bool fits =
        entry->state == InboxState::kAdmitted && directory_.has_place(network, name.address, entry->announced.join.id);
    return fits ? retry(network, name) : nullptr;
  }
  if (Device* device = nullptr; claimed_elsewhere(network, name.address, device)) return device;
  ++network.faults.unknown_devices;
  network_tuples_.refresh_counters();
  context_.warn(network.id + "/stranger", fmt::format("{} from {}, which never joined", to_string(message.kind()),
                                                      model::quoted(to_string(message.source))));
  return nullptr;
}

/// True: another island lists the device, or did. `device` is set if it is listed here now.
bool Admission::claimed_elsewhere(Network& network, const std::string& address, Device*& device) {
  const auto where = roaming_.on_message(network, address);
  if (where == Roaming::Whereabouts::kUnknown) return false;
  if (where == Roaming::Whereabouts::kReturned) device = take_over({network.id, address});
  if (!device) {
    ++network.faults.roamed_messages;
    network_tuples_.refresh_counters();
  }
  return true;
}

/// Lists a device that was away, if what it last announced is still admitted; else nullptr.
Device* Admission::take_over(const DeviceName& name) {
  const auto announced = roaming_.take(name);
  if (!announced) return nullptr;
  auto& network = directory_.network(name.network);
  const auto known = memory_.recall(name.network, name.address);
  const auto* remembered = known ? &*known : nullptr;
  auto ruling = decide(network, name, announced->join, remembered, is_configured(network, announced->join));
  if (ruling.is_admitted()) return list(network, name.address, *announced, remembered);
  keep_out(name, *announced, remembered, std::move(ruling));
  return nullptr;
}

void Admission::on_leave(const DeviceName& name) {
  roaming_.forget(name);
  const auto* entry = inbox_.find(name);
  if (!entry || entry->ignored()) return;
  const auto known = memory_.recall(name.network, name.address);
  const auto decision = known ? known->decision : Decision::kNone;
  if (decision == Decision::kNone) {
    memory_.forget(name.network, name.address);
  } else {
    memory_.save_unlisted(name.network, name.address, entry->announced.join, decision);
  }
  inbox_.take(name);
}

void Admission::restore(const std::string& id) {
  memory_.each(id, [this](Memory::Row row, KnownDevice&& known) {
    if (context_.config.networks.contains(known.network))
      restore(directory_.network(known.network), row, std::move(known));
  });
}

void Admission::restore(Network& network, Memory::Row row, KnownDevice&& known) {
  const DeviceName name{network.id, known.address};
  Announced announced{known.join, {}};
  announced.join.heard = false;
  if (known.id.empty() && known.decision == Decision::kApproved) return;  // it left
  auto ruling = decide(network, name, announced.join, &known, false);
  if (!ruling.is_admitted()) return keep_out(name, announced, &known, std::move(ruling));
  if (network.rules.lists_devices) return;
  if (auto* device = list_unless_claimed(network, name.address, announced, &known)) Memory::restore_row(*device, row);
}

void Admission::reevaluate_inbox() {
  for (const auto& name : inbox_.devices()) {
    const auto* entry = inbox_.find(name);
    if (!entry) continue;
    auto& network = directory_.network(name.network);
    const auto announced = entry->announced;
    auto ruling = decide(network, name, announced.join, nullptr, false);
    if (ruling.is_admitted()) {
      retry(network, name);
    } else {
      keep_out(name, announced, nullptr, std::move(ruling));
    }
  }
}

void Admission::change_domain(Network& network, const std::string& domain) {
  if (network.rules.roaming == domain) return;
  for (const auto& device : network.devices.all()) roaming_.withdraw_claim(*device);
  const auto away = roaming_.drop_network(network.id);
  network.rules.roaming = domain;
  roaming_.follow_domains();
  roaming_.enter_domain(network);
  for (const auto& [name, announced] : away) {
    const auto known = memory_.recall(name.network, name.address);
    const auto* remembered = known ? &*known : nullptr;
    auto ruling = decide(network, name, announced.join, remembered, is_configured(network, announced.join));
    if (ruling.is_admitted()) {
      list_unless_claimed(network, name.address, announced, remembered);
    } else {
      keep_out(name, announced, remembered, std::move(ruling));
    }
  }
}

void Admission::drop_network(const std::string& id) {
  inbox_.drop_network(id);
  roaming_.drop_network(id);
  std::erase_if(decisions_, [&id](const auto& one) { return one.first.network == id; });
}

// What users decide about devices of the inbox.

namespace {

/// Decisions carried out in one turn of the loop.
constexpr std::size_t kDecisionsATurn = 200;

std::optional<Decision> decision_of(std::string_view word) {
  if (word == "approve") return Decision::kApproved;
  if (word == "ignore") return Decision::kIgnored;
  if (word == "forget") return Decision::kNone;
  return std::nullopt;
}

}  // namespace

/// kInvalid: the text is none of `approve`, `ignore` and `forget`, or lacks the pattern.
Result<Admission::Order> Admission::read_order(const tuples::RemoteSet& request, const std::string& root) {
  const bool many = request.key == root;
  const std::string_view text = request.value;
  const auto blank = many ? text.find(' ') : text.npos;
  const auto decision = decision_of(text.substr(0, blank));
  if (!decision || (many && (blank == text.npos || blank + 1 == text.size()))) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected {}, got {}", model::quoted(request.key),
                                                 many ? "approve, ignore or forget and a pattern such as wsn-1.*"
                                                      : "approve, ignore or forget",
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

/// Finds a device by its key in the inbox, by the key of its address, and by the key of its tuples.
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

/// What a name without wildcards means: the device that waits, an ignored one, or, to be ignored or forgotten, a listed
/// one. Patterns mean only devices that wait.
std::vector<DeviceName> Admission::named(const Order& order) {
  auto found = inbox_.with_key(order.pattern);
  if (!found.empty() || order.decision == Decision::kApproved) return found;
  const auto dot = order.pattern.find('.');
  const auto network = order.pattern.substr(0, dot);
  const auto* device = directory_.find_by_key(order.pattern);
  if (!device && dot != order.pattern.npos && directory_.networks().contains(network))
    device = directory_.network(network).devices.find(std::string_view(order.pattern).substr(dot + 1));
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
  for (const auto& [name, decision] : slice) {
    switch (decision) {
      case Decision::kApproved: approve(name); break;
      case Decision::kIgnored: ignore(name); break;
      case Decision::kNone: forget(name); break;
    }
  }
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
  if (auto* device = directory_.network(name.network).devices.find(name.address)) {
    announced = last_announcement(*device);
    callbacks_.ignored(*device);
  }
  roaming_.forget(name);
  context_.log.info(fmt::format("{} is ignored from now on", key_of(name)));
  inbox_.put(name, announced, InboxState::kIgnoredByUser, std::string(kDecidedByUser));
  memory_.save_unlisted(name.network, name.address, announced.join, Decision::kIgnored);
}

/// As if it had never been heard: what it announces next is that of a new device.
void Admission::forget(const DeviceName& name) {
  if (auto* device = directory_.network(name.network).devices.find(name.address)) callbacks_.ignored(*device);
  roaming_.forget(name);
  inbox_.take(name);
  memory_.forget(name.network, name.address);
  context_.log.info(fmt::format("{} is forgotten", key_of(name)));
}

}  // namespace rubicon::proxy::admission
