#include <cstdlib>

#include "fuzz_target.h"
#include "networks/zigbee/bridge/groups.h"
#include "networks/zigbee/bridge/messages.h"
#include "networks/zigbee/bridge/settings.h"
#include "networks/zigbee/bridge/topics.h"

namespace rubicon::fuzz::zigbee_bridge_fuzz {

namespace {

using namespace rubicon::networks::zigbee::bridge;

void groups(std::string_view payload) {
  const auto list = read_groups(payload);
  if (!list) return;
  Topics topics("z");
  for (const auto& group : list->groups) topics.put(group.address(), group.name);
  for (const auto& group : list->groups) {
    const auto found = topics.find(topics.state(group.name), "{}");
    if (!found && topics.conflict(group.address()).empty()) std::abort();
  }
  Groups records;
  const auto none = [](const auto&) { return nullptr; };
  if (records.replace(list->groups, none).changed.size() != list->groups.size()) std::abort();
  if (records.records().size() != list->groups.size()) std::abort();
  for (const auto& group : list->groups) topics.remove(group.address());
  if (topics.filters().size() != Topics("z").filters().size()) std::abort();
}

void response(std::string_view payload) {
  const auto read = read_response(payload);
  if (!read) return;
  if (read->ok != read->error.empty()) std::abort();
  (void)read_network_map(read->data);
}

}  // namespace

/// Input: a payload of bridge/info, response, health, groups or state; it is read as each of them.
FUZZ_TARGET(zigbee_bridge) {
  const std::string_view payload(reinterpret_cast<const char*>(data), size);
  if (const auto bridge = read_info(payload)) {
    (void)check_version(*bridge);
    (void)recommendations(*bridge);
    for (const auto& [address, options] : bridge->of) {
      if (bridge->optimistic(address) != options.optimistic.value_or(bridge->all.optimistic.value_or(true)))
        std::abort();
    }
  }
  (void)read_online(payload);
  (void)read_health(payload);
  response(payload);
  groups(payload);
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_bridge_fuzz
