#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "base/glob.h"
#include "proxy/naming.h"
#include "proxy/proxy_impl.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

using state::Decision;
using state::KnownDevice;

constexpr std::string_view kByUser = "a user decided so";
/// Decisions carried out in one turn of the loop.
constexpr std::size_t kSlice = 200;

std::optional<Decision> decision_of(std::string_view word) {
  if (word == "approve") return Decision::kApproved;
  if (word == "ignore") return Decision::kIgnored;
  return std::nullopt;
}

}  // namespace

Announced last_said(const Device& device) {
  Announced announced{announcement(device), device.heard_at, device.joined};
  announced.join.heard = device.status != DeviceStatus::kUnknown;
  return announced;
}

/// Ignored by a user: no. Known before, named in the configuration or by its network's options: yes. Else the rules.
bool Proxy::Impl::let_in(Network& network, const DeviceName& name, const Announced& announced, const KnownDevice* known,
                         bool listed) {
  const auto* entry = inbox.find(name);
  const bool hidden =
      entry ? entry->standing == Standing::kIgnoredByUser : known && known->decision == Decision::kIgnored;
  if (hidden) {
    inbox.put(name, announced, Standing::kIgnoredByUser, std::string(kByUser));
    return false;
  }
  const bool trusted = entry ? entry->standing == Standing::kLetIn
                             : known && (known->decision == Decision::kApproved || !known->id.empty());
  if (trusted || listed || roaming.trusts(name) || names_of(network.rules, name.address) != nullptr) return true;
  auto [admission, why] = inbox.admission(name, announced.join);
  if (admission == Admission::kAuto) return true;
  const bool asks = admission == Admission::kAsk;
  const auto put = inbox.put(name, announced, asks ? Standing::kWaits : Standing::kIgnoredByRule, std::move(why));
  const bool news = put == DiscoveryInbox::Put::kNews && !(known && says_the_same(known->join, announced.join));
  if (asks && news) memory.absent(name.network, name.address, announced.join, Decision::kNone);
  return false;
}

/// It may come, and cannot now: it is tried again when it speaks, and at a reload.
void Proxy::Impl::park(const DeviceName& name, const Announced& announced, const std::string& why) {
  context.warn(name.network + "/join", why);
  inbox.put(name, announced, Standing::kLetIn, why);
}

/// With what is remembered of it; nullptr if it still cannot come.
Device* Proxy::Impl::try_again(Network& network, const DeviceName& name, bool approved) {
  const auto announced = inbox.find(name)->announced;
  const auto known = memory.recall(name.network, name.address);
  if (!enter(network, name.address, announced, known ? &*known : nullptr, approved)) return nullptr;
  return directory.find(network, name.address);
}

void Proxy::Impl::bring_back(Device& device, const KnownDevice& known) {
  device.decision = known.decision;
  device.given_name = known.given_name;
  device.given_area = known.area;
  if (directory.take_name(device)) mirror.described(device);
  for (const auto& stored : known.values) {
    auto* point = find_point(device, stored.point);
    if (!point) {
      point = directory.add_undeclared(device, stored.point);
      if (!point) continue;
      mirror.added(device, *point);
    }
    point->details->set_by_user = stored.set_by_user;
    if (!is_rate(*point)) {
      mirror.remembered(device, *point, stored);
      continue;
    }
    const auto value = TypeCatalogue::parse(*point->type, to_text(stored.value));
    const auto rate = value ? rate_of(*value) : std::nullopt;
    if (!rate || !stored.set_by_user) continue;
    device.rate = *rate;
    mirror.own_value(device, *point, *value, Quality::kGood);
  }
}

void Proxy::Impl::restore(const std::string& id) {
  memory.each(id, [this](Memory::Row row, KnownDevice&& known) {
    if (config.networks.contains(known.network)) restore(directory.network(known.network), row, std::move(known));
  });
}

void Proxy::Impl::restore(Network& network, Memory::Row row, KnownDevice&& known) {
  const DeviceName name{network.id, known.address};
  Announced announced{known.join, {}};
  announced.join.heard = false;
  if (known.id.empty() && known.decision == Decision::kApproved) return;  // it left
  if (!let_in(network, name, announced, &known, false) || network.rules.lists_devices) return;
  if (!enter(network, name.address, announced, &known)) return;
  directory.find(network, name.address)->state_row = row;
}

/// `approve` on `proxy.inbox.wsn-1.7`, or `approve wsn-1.*` on `proxy.inbox`.
tuples::SetDecision Proxy::Impl::judge_inbox(const tuples::RemoteSet& wish) {
  const auto root = config.prefix + ".inbox";
  const bool many = wish.key == root;
  const std::string_view text = wish.value;
  const auto blank = many ? text.find(' ') : text.npos;
  const auto decision = decision_of(text.substr(0, blank));
  if (!decision || (many && (blank == text.npos || blank + 1 == text.size()))) {
    return tuples::SetDecision::refused(
        {ErrorCode::kInvalid,
         fmt::format("{}: expected {}, got {}", model::quoted(wish.key),
                     many ? "approve or ignore and a pattern such as wsn-1.*" : "approve or ignore",
                     model::quoted(text))});
  }
  const std::string pattern = many ? std::string(text.substr(blank + 1)) : wish.key.substr(root.size() + 1);
  auto found = many ? inbox.waiting_like(pattern) : inbox.meant_by(pattern);
  if (found.size() > 1 && !many) {
    return tuples::SetDecision::refused(
        {ErrorCode::kDuplicate, fmt::format("{} fits {} devices: set {} to {} {}.<address>", model::quoted(pattern),
                                            found.size(), root, text, found.front().network)});
  }
  if (found.empty() && !many && *decision == Decision::kIgnored) {
    if (const auto* device = device_with_key(pattern)) found.push_back({device->network->id, device->address});
  }
  if (found.empty()) {
    return tuples::SetDecision::refused(
        {ErrorCode::kNotFound, fmt::format("no device {} waits", model::quoted(pattern))});
  }
  if (decisions.size() + found.size() > 2 * config.max_devices)
    return tuples::SetDecision::refused({ErrorCode::kBusy, "too many decisions at once, try again"});
  for (auto& name : found) decisions.emplace_back(std::move(name), *decision);
  decisions_turn.request();
  return tuples::SetDecision::consumed();
}

/// `wsn-1.7` -> the device that is published under it.
Device* Proxy::Impl::device_with_key(std::string_view parts) {
  const auto key = fmt::format("{}.{}", config.prefix, parts);
  for (const auto& [id, network] : directory.networks()) {
    if (!key.starts_with(network->key + ".")) continue;
    const auto found = network->by_id.find(key.substr(network->key.size() + 1));
    if (found != network->by_id.end()) return found->second;
  }
  return nullptr;
}

void Proxy::Impl::carry_out() {
  context.clock.refresh();
  const auto end = decisions.begin() + static_cast<std::ptrdiff_t>(std::min(decisions.size(), kSlice));
  const std::vector slice(std::move_iterator(decisions.begin()), std::move_iterator(end));
  decisions.erase(decisions.begin(), end);
  for (const auto& [name, decision] : slice) decision == Decision::kApproved ? approve(name) : ignore(name);
  if (!decisions.empty()) decisions_turn.request();
}

void Proxy::Impl::approve(const DeviceName& name) {
  const auto* entry = inbox.find(name);
  if (!entry) return;
  const auto join = entry->announced.join;
  context.log.info(fmt::format("{} was approved", key_of(name)));
  if (auto* device = try_again(directory.network(name.network), name, true)) {
    memory.approved(*device);
  } else {
    memory.absent(name.network, name.address, join, Decision::kApproved);
  }
}

void Proxy::Impl::ignore(const DeviceName& name) {
  Announced announced;
  if (const auto* entry = inbox.find(name)) announced = entry->announced;
  if (auto* device = directory.find(directory.network(name.network), name.address)) {
    announced = last_said(*device);
    demand.stop(*device);
    memory.dropped(std::array{device});
    remove(*device);
  }
  roaming.forget(name);
  context.log.info(fmt::format("{} is ignored from now on", key_of(name)));
  inbox.put(name, announced, Standing::kIgnoredByUser, std::string(kByUser));
  memory.absent(name.network, name.address, announced.join, Decision::kIgnored);
}

}  // namespace rubicon::proxy
