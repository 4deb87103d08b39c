#include "apps/rubicon-proxy/interfaces_part.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "model/json_text.h"

namespace rubicon::daemon {

std::string interfaces_text(const tuples::dds::InterfaceNews& news) {
  if (news.interfaces.empty()) return {};
  auto all = nlohmann::ordered_json::array();
  for (const auto& [name, state] : news.interfaces)
    all.push_back({{"name", name}, {"address", state.address}, {"lack", state.lack}});
  const auto changed = std::chrono::floor<std::chrono::seconds>(news.changed.time_since_epoch()).count();
  return model::dump({{"interfaces", std::move(all)}, {"changes", news.changes}, {"changed", changed}});
}

void show_interfaces(island::Island& island, const tuples::dds::DdsEcology& ecology) {
  island.show_word("dds-interfaces", [&ecology] { return interfaces_text(ecology.interfaces()); });
}

}  // namespace rubicon::daemon
