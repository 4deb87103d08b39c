#include "networks/zigbee/bridge/topics.h"

#include <fmt/format.h>

#include <algorithm>

#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/messages.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

constexpr std::size_t kMaxBase = 200;
constexpr std::string_view kResponse = "response/";

/// A payload of `<name>/availability`: nothing but the word. A state has more members, or `state` is another word.
bool is_availability(std::string_view payload) {
  constexpr std::size_t kMaxLength = 64;
  return payload.size() <= kMaxLength && read_online(payload).has_value();
}

bool is_of_the_bridge(std::string_view name) {
  return name == "bridge" || name.starts_with("bridge/");
}

bool is_verb(std::string_view level) {
  return level == "set" || level == "get";
}

}  // namespace

std::string new_name_problem(std::string_view name) {
  if (auto problem = name_problem(name); !problem.empty()) return problem;
  if (is_of_the_bridge(name)) return fmt::format("'{}' is a topic of the bridge: begin with another word", name);
  for (auto slash = name.find('/'); slash != name.npos; slash = name.find('/', slash + 1)) {
    const auto rest = name.substr(slash + 1);
    const auto level = rest.substr(0, rest.find('/'));
    if (!is_verb(level) && rest != "availability") continue;
    return fmt::format("'{}' is a topic of a device '{}': '/{}' is reserved there, use another word", name,
                       name.substr(0, slash), level);
  }
  return {};
}

Result<void> Topics::check_base(std::string_view base) {
  if (base.size() > kMaxBase) return fail(ErrorCode::kInvalid, fmt::format("longer than {} bytes", kMaxBase));
  if (!name_problem(base).empty())
    return fail(ErrorCode::kInvalid, "must be UTF-8 without +, #, control characters and slashes at its ends");
  return {};
}

Topics::Topics(std::string base) : base_(std::move(base)), bridge_(base_ + "/bridge/") {
  own_ = {{bridge_ + "state", Kind::kBridgeState}, {bridge_ + "info", Kind::kInfo},
          {bridge_ + "devices", Kind::kDevices},   {bridge_ + "groups", Kind::kGroups},
          {bridge_ + "event", Kind::kEvent},       {bridge_ + "health", Kind::kHealth}};
}

std::string Topics::state(std::string_view name) const {
  return fmt::format("{}/{}", base_, name);
}

Topics::Filters Topics::put(const std::string& address, const std::string& name) {
  const auto known = names_.find(address);
  if (known != names_.end() && known->second == name) return {};
  Filters filters;
  // The new topics first: one that has the same name for a moment keeps its subscription.
  add(state(name), address, Kind::kState, filters);
  add(availability(name), address, Kind::kAvailability, filters);
  if (known != names_.end()) {
    drop(state(known->second), address, Kind::kState, filters);
    drop(availability(known->second), address, Kind::kAvailability, filters);
  }
  names_[address] = name;
  return filters;
}

Topics::Filters Topics::remove(const std::string& address) {
  Filters filters;
  const auto known = names_.find(address);
  if (known == names_.end()) return filters;
  drop(state(known->second), address, Kind::kState, filters);
  drop(availability(known->second), address, Kind::kAvailability, filters);
  names_.erase(known);
  return filters;
}

void Topics::add(const std::string& topic, const std::string& address, Kind kind, Filters& filters) {
  auto& meanings = table_[topic];
  if (meanings.empty() && !own_.contains(topic)) filters.added.push_back(topic);
  meanings.push_back({address, kind});
}

void Topics::drop(const std::string& topic, const std::string& address, Kind kind, Filters& filters) {
  const auto found = table_.find(topic);
  if (found == table_.end()) return;
  std::erase_if(found->second, [&](const auto& meaning) { return meaning.address == address && meaning.kind == kind; });
  if (!found->second.empty()) return;
  table_.erase(found);
  if (!own_.contains(topic)) filters.removed.push_back(topic);
}

std::optional<Topics::Found> Topics::find(std::string_view topic, std::string_view payload) const {
  if (topic.starts_with(bridge_)) {
    if (const auto own = own_.find(topic); own != own_.end()) return Found{own->second, {}, {}};
    if (topic.substr(bridge_.size()).starts_with(kResponse))
      return Found{Kind::kResponse, {}, topic.substr(bridge_.size() + kResponse.size())};
  }
  const auto found = table_.find(topic);
  if (found == table_.end()) return std::nullopt;
  const auto& meanings = found->second;
  // A topic that means a state ends with the name of the entity.
  const bool conflicts = !name_conflict(topic.substr(base_.size() + 1)).empty();
  const auto* chosen = &meanings.back();
  if (meanings.size() > 1) {
    const auto wanted = is_availability(payload) ? Kind::kAvailability : Kind::kState;
    const auto fits = std::find_if(meanings.rbegin(), meanings.rend(), [&](const auto& meaning) {
      return meaning.kind == wanted && (wanted != Kind::kState || !conflicts);
    });
    if (fits == meanings.rend()) return std::nullopt;
    chosen = &*fits;
  }
  if (chosen->kind == Kind::kState && conflicts) return std::nullopt;
  return Found{chosen->kind, chosen->address, {}};
}

std::string Topics::conflict(const std::string& address) const {
  const auto known = names_.find(address);
  return known == names_.end() ? std::string() : name_conflict(known->second);
}

std::string Topics::name_conflict(std::string_view name) const {
  if (is_of_the_bridge(name))
    return fmt::format("its friendly name '{}' is a topic of the bridge; rename it in Zigbee2MQTT", name);
  for (auto slash = name.find('/'); slash != name.npos; slash = name.find('/', slash + 1)) {
    const auto rest = name.substr(slash + 1);
    const auto verb = rest.substr(0, rest.find('/'));
    if (!is_verb(verb)) continue;
    const auto owner = name.substr(0, slash);
    if (!table_.contains(state(owner))) continue;
    return fmt::format("its friendly name '{}' is a topic for commands to '{}'; rename it in Zigbee2MQTT", name, owner);
  }
  return {};
}

std::vector<std::string> Topics::filters() const {
  std::vector<std::string> all;
  for (const auto& [topic, kind] : own_) all.push_back(topic);
  all.push_back(bridge_ + std::string(kResponse) + "#");
  const auto of_entities = all.size();
  for (const auto& [topic, meanings] : table_) {
    if (!own_.contains(topic)) all.push_back(topic);
  }
  std::sort(all.begin() + static_cast<std::ptrdiff_t>(of_entities), all.end());
  return all;
}

}  // namespace rubicon::networks::zigbee::bridge
