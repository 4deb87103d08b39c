#include "proxy/admission/admission.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "proxy/admission/discovery_rules.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"

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
  if (directory_.find(network, address) || !roaming_.defers(network, address, announced, approved))
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
  for (auto& [address, device] : network.devices) roaming_.withdraw_claim(device);
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

}  // namespace rubicon::proxy::admission
