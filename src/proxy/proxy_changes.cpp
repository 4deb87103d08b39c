#include "proxy/proxy_impl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "model/json_text.h"
#include "proxy/command.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

/// First the networks that are removed, then new and changed ones: a key part given up can be taken at once.
void Proxy::Impl::reconfigure(ProxyConfig next) {
  context.clock.refresh();
  next.prefix = config.prefix;
  next.island_name = config.island_name;
  next.host = config.host;
  const auto before = std::exchange(config, std::move(next)).networks;
  bool networks_changed = false;
  for (const auto& [id, rules] : before) {
    if (config.networks.contains(id)) continue;
    networks_changed = true;
    drop_network(id);
  }
  for (const auto& [id, rules] : config.networks) {
    const auto old = before.find(id);
    if (old == before.end()) {
      networks_changed = true;
      auto& network = directory.network(id);
      directory.configure(network, rules);
      network_tuples.declare(network);
      admission.roaming().follow_domains();
      admission.restore(id);
    } else if (!(old->second == rules)) {
      change_rules(directory.network(id), rules);
    }
  }
  if (networks_changed) {
    network_tuples.networks_changed();
    admission.roaming().follow_domains();
  }
  network_tuples.refresh_counters();
  admission.reevaluate_inbox();
}

void Proxy::Impl::restart(const std::string& id) {
  context.clock.refresh();
  auto& network = directory.network(id);
  drop_devices(network);
  network.line = model::LineState::kConnecting;
  network.line_known = network.down = false;
  network.since = context.clock.now().wall;
  network.reason.clear();
  network.finding.clear();
  network_tuples.line_changed(network);
  admission.restore(id);
}

void Proxy::Impl::drop_network(const std::string& id) {
  auto& network = directory.network(id);
  drop_devices(network);
  admission.drop_network(id);
  network_tuples.remove(network);
  directory.remove_network(id);
}

/// Removes the devices from the tuple space; the state file keeps what it remembers of them.
void Proxy::Impl::drop_devices(Network& network) {
  std::vector<Device*> devices;
  for (const auto& device : network.devices.all()) devices.push_back(device.get());
  memory.save_before_removal(devices);
  for (auto* device : devices) remove(*device);
}

void Proxy::Impl::change_rules(Network& network, NetworkRules rules) {
  std::vector<Device*> renamed;
  for (const auto& device : network.devices.all()) adopt_names(rules, device->address, device->announced_name);
  for (const auto& device : network.devices.all()) {
    const auto& address = device->address;
    if (!same_keys(names_of(network.rules, address), names_of(rules, address))) renamed.push_back(device.get());
  }
  const auto old_rate = network.rules.rate;
  admission.change_domain(network, rules.roaming);
  rename(network, std::move(rules), renamed);
  for (const auto& listed : network.devices.all()) {
    auto& device = *listed;
    if (directory.update_name(device)) mirror.described(device);
    for (auto& point : device.points) directory.doubt(device, point);
    if (old_rate != network.rules.rate && device.rate == old_rate) set_rate(device, network.rules.rate);
    liveness.watch(device);
  }
}

void Proxy::Impl::set_rate(Device& device, std::chrono::milliseconds rate) {
  device.rate = rate;
  auto* point = find_point(device, device.rate_point);
  if (point) mirror.own_value(device, *point, static_cast<std::int64_t>(rate.count()), Quality::kGood);
  demand.changed(device);
}

/// A device that holds a key which the configuration reserves for another one is deferred until it gets a free key.
void Proxy::Impl::free_reserved_keys(Network& network) {
  for (const auto& [id, address] : network.reserved) {
    const auto found = network.by_id.find(std::string_view(id));
    if (found == network.by_id.end() || (*found)->address == address) continue;
    auto& holder = **found;
    const auto announced = last_announcement(holder);
    const DeviceName name{network.id, holder.address};
    const auto why = fmt::format("{} gave up its key to {}, for which the configuration reserves it", holder.key,
                                 model::quoted(address));
    memory.save_before_removal(std::array{&holder});
    remove(holder);
    admission.defer(name, announced, why);
  }
}

/// Frees all old keys before it gives the first new one, so that two devices can swap theirs.
void Proxy::Impl::rename(Network& network, NetworkRules rules, const std::vector<Device*>& renamed) {
  memory.save_before_removal(renamed);  // before one of them finds no key
  std::vector<std::map<PointNumber, TupleMirror::Kept>> kept;
  for (auto* device : renamed) {
    kept.push_back(mirror.retire(*device));
    directory.release(*device);
  }
  directory.configure(network, std::move(rules));
  free_reserved_keys(network);
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    auto& device = *renamed[i];
    const auto vanished = directory.name(device);
    if (!vanished) {
      const auto announced = last_announcement(device);
      const DeviceName name{network.id, device.address};
      admission.roaming().withdraw_claim(device);
      desk.forget(device);
      demand.forget(device);
      directory.remove(device);
      admission.defer(name, announced, vanished.error().text);
      continue;
    }
    for (const auto& point : *vanished) desk.forget(device, point.number);
    demand.reset(device);
    mirror.renamed(device, kept[i]);
    admission.roaming().publish_claim(device);
    memory.record_changed(device);
    demand.changed(device);
  }
  network_tuples.devices_changed(network);
}

namespace {

using nlohmann::json;

constexpr std::string_view kForm = R"(expected {"name": TEXT, "area": TEXT}, one of them or both; "" removes it)";

/// A name that a user may give: no control characters, not longer than the state file keeps.
Result<std::string> given_text(const json& value, const std::string& what) {
  if (!value.is_string()) return fail(ErrorCode::kInvalid, fmt::format("{}: {}", what, kForm));
  auto text = value.get<std::string>();
  if (text.size() > state::kMaxGiven) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes, at most {} are kept", what, text.size(), state::kMaxGiven));
  }
  const bool control = std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (control)
    return fail(ErrorCode::kInvalid, fmt::format("{}: a control character in {}", what, model::quoted(text)));
  return text;
}

}  // namespace

tuples::SetDecision UserNames::decide_set(const tuples::RemoteSet& request) {
  const auto head = context_.config.prefix.size() + 1;
  const auto parts = std::string_view(request.key).substr(head, request.key.rfind('.') - head);
  auto* device = directory_.find_by_key(parts);
  const auto refused = [](Error why) { return tuples::SetDecision::refused(std::move(why)); };
  if (!device)
    return refused({ErrorCode::kNotFound, fmt::format("{}: no such device here", model::quoted(request.key))});
  const auto tree = model::parse_json(request.value);
  if (!tree.is_object() || tree.empty())
    return refused({ErrorCode::kInvalid, fmt::format("{}: {}", request.key, kForm)});
  auto name = device->given_name.text(), area = device->given_area.text();
  for (const auto& [member, value] : tree.items()) {
    auto* target = member == "name" ? &name : member == "area" ? &area : nullptr;
    if (!target) {
      return refused(
          {ErrorCode::kRefused, fmt::format("{}: users cannot set {}; {}", request.key, model::quoted(member), kForm)});
    }
    auto text = given_text(value, fmt::format("{}: {}", request.key, member));
    if (!text) return refused(std::move(text.error()));
    const auto* fixed = names_of(device->network->rules, device->address);
    const bool taken = fixed && !(target == &name ? fixed->name : fixed->area).empty();
    if (taken && !text->empty()) {
      return refused(
          {ErrorCode::kRefused, fmt::format("the configuration gives {} its {}: change networks.{}.devices.{}.{} there",
                                            device->key, member, device->network->id, device->address, member)});
    }
    *target = std::move(*text);
  }
  if (auto done = give(*device, std::move(name), std::move(area), request.from); !done) return refused(done.error());
  return tuples::SetDecision::consumed();
}

Result<void> UserNames::give(Device& device, std::string name, std::string area, OwnerId by) {
  auto name_before = std::exchange(device.given_name, RareText()),
       area_before = std::exchange(device.given_area, RareText());
  device.given_name = std::move(name);
  device.given_area = std::move(area);
  if (auto done = memory_.save_names(device); !done) {
    device.given_name = std::move(name_before);
    device.given_area = std::move(area_before);
    return fail(done.error().code, fmt::format("{} keeps its name: {}", device.key, done.error().text));
  }
  if (directory_.update_name(device)) mirror_.described(device);
  context_.log.info(fmt::format("{} is called {} in area {} by {}, id {}", device.key, model::quoted(device.name),
                                model::quoted(device.area.text()), commander_name(context_.space, context_.config, by),
                                number(by)));
  return {};
}

}  // namespace rubicon::proxy
