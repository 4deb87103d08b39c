#include <fmt/format.h>

#include "base/glob.h"
#include "model/key.h"
#include "proxy/naming.h"
#include "proxy/proxy_parts.h"

namespace rubicon::proxy {

namespace {

using state::Decision;
using state::KnownDevice;

constexpr std::string_view kByUser = "a user decided so";

bool says_the_same(const model::Join& one, const model::Join& other) {
  return one.name == other.name && one.model == other.model && one.device_type == other.device_type &&
         one.capabilities == other.capabilities;
}

std::optional<Decision> decision_of(std::string_view word) {
  if (word == "approve") return Decision::kApproved;
  if (word == "ignore") return Decision::kIgnored;
  return std::nullopt;
}

}  // namespace

/// Ignored by a user: no. Known before, named in the configuration or by its network's options: yes. Else the rules.
bool Proxy::Parts::let_in(Network& network, const std::string& address, const model::Join& join,
                          const std::optional<KnownDevice>& known) {
  const DeviceName name{network.id, address};
  const auto* entry = inbox.find(name);
  if (known && known->decision == Decision::kIgnored && !entry) inbox.ignore(name, join, std::string(kByUser));
  const bool by_user =
      (known && known->decision == Decision::kIgnored) || (entry && entry->ignored && entry->why == kByUser);
  if (by_user) {
    inbox.heard(name);
    return false;
  }
  const bool trusted = (known && (known->decision == Decision::kApproved || !known->id.empty())) || !join.heard ||
                       names_of(network.rules, address) != nullptr;
  auto [admission, why] = trusted ? std::pair(Admission::kAuto, std::string()) : inbox.admission(name, join);
  if (admission == Admission::kAuto) {
    inbox.take(name);
    return true;
  }
  const bool asks = admission == Admission::kAsk;
  const bool news = asks && (!entry || entry->ignored || !says_the_same(entry->join, join));
  asks ? inbox.wait(name, join, std::move(why)) : inbox.ignore(name, join, std::move(why));
  if (news && inbox.find(name)) memory.absent(name.network, name.address, join, Decision::kNone);
  inbox.heard(name);
  return false;
}

void Proxy::Parts::bring_back(Device& device, const KnownDevice& known) {
  device.decision = known.decision;
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

void Proxy::Parts::restore() {
  memory.each({}, [this](KnownDevice&& known) {
    if (!config.networks.contains(known.network)) return;
    auto& network = directory.network(known.network);
    restore(network, std::move(known));
  });
}

void Proxy::Parts::restore(const std::string& id) {
  memory.each(id, [this](KnownDevice&& known) {
    auto& network = directory.network(known.network);
    restore(network, std::move(known));
  });
}

void Proxy::Parts::restore(Network& network, KnownDevice&& known) {
  const DeviceName name{network.id, known.address};
  known.join.heard = false;
  if (known.decision == Decision::kIgnored) {
    inbox.ignore(name, known.join, std::string(kByUser));
    return;
  }
  const bool named = names_of(network.rules, known.address) != nullptr;
  if (known.id.empty()) {
    if (known.decision == Decision::kApproved) return;  // it left
    auto [admission, why] = named ? std::pair(Admission::kAuto, std::string()) : inbox.admission(name, known.join);
    if (admission == Admission::kAsk) inbox.wait(name, known.join, std::move(why));
    if (admission != Admission::kAuto) return;
  }
  if (!network.rules.lists_devices) admit(network, {known.address, known.join, {}}, &known);
}

/// `approve` on `proxy.inbox.wsn-1.7`, or `approve wsn-1.*` on `proxy.inbox`.
tuples::Judgement Proxy::Parts::judge_inbox(const tuples::RemoteSet& wish) {
  const auto root = config.prefix + ".inbox";
  const bool many = wish.key == root;
  const std::string_view text = wish.value;
  const auto blank = many ? text.find(' ') : text.npos;
  const auto decision = decision_of(text.substr(0, blank));
  if (!decision || (many && (blank == text.npos || blank + 1 == text.size()))) {
    return tuples::Judgement::refused(
        {ErrorCode::kInvalid,
         fmt::format("{}: expected {}, got {}", model::quoted(wish.key),
                     many ? "approve or ignore and a pattern such as wsn-1.*" : "approve or ignore",
                     model::quoted(text))});
  }
  const std::string pattern = many ? std::string(text.substr(blank + 1)) : wish.key.substr(root.size() + 1);
  std::vector<DeviceName> found;
  for (auto& name : inbox.matching(pattern)) {
    if (!many || !inbox.find(name)->ignored) found.push_back(std::move(name));
  }
  if (found.empty() && !many && *decision == Decision::kIgnored) {
    if (const auto* device = device_with_key(pattern)) found.push_back({device->network->id, device->address});
  }
  if (found.empty()) {
    return tuples::Judgement::refused(
        {ErrorCode::kNotFound, fmt::format("no device {} waits", model::quoted(pattern))});
  }
  for (auto& name : found) decisions.emplace_back(std::move(name), *decision);
  decisions_turn.ask();
  return tuples::Judgement::consumed();
}

/// `wsn-1.7` -> the device that is published under it.
Device* Proxy::Parts::device_with_key(std::string_view parts) {
  const auto key = fmt::format("{}.{}", config.prefix, parts);
  for (const auto& [id, network] : directory.networks()) {
    if (!key.starts_with(network->key + ".")) continue;
    const auto found = network->by_id.find(key.substr(network->key.size() + 1));
    if (found != network->by_id.end()) return found->second;
  }
  return nullptr;
}

void Proxy::Parts::carry_out() {
  around.clock.refresh();
  for (const auto& [name, decision] : std::exchange(decisions, {})) {
    decision == Decision::kApproved ? approve(name) : ignore(name);
  }
}

void Proxy::Parts::approve(const DeviceName& name) {
  auto entry = inbox.take(name);
  if (!entry) return;
  around.log.info(fmt::format("{} was approved", key_of(name)));
  auto& network = directory.network(name.network);
  admit(network, {name.address, entry->join, entry->heard_at}, nullptr);
  if (auto* device = directory.find(network, name.address)) memory.approved(*device);
}

void Proxy::Parts::ignore(const DeviceName& name) {
  model::Join join;
  if (const auto* entry = inbox.find(name)) join = entry->join;
  if (auto* device = directory.find(directory.network(name.network), name.address)) {
    join = announcement(*device);
    remove(*device);
  }
  around.log.info(fmt::format("{} is ignored from now on", key_of(name)));
  inbox.ignore(name, join, std::string(kByUser));
  memory.absent(name.network, name.address, join, Decision::kIgnored);
}

}  // namespace rubicon::proxy
