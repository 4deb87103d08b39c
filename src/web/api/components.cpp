#include "web/api/components.h"

#include <numeric>
#include <string>

#include "rubicon/summary.hpp"

namespace rubicon::web::api {

nlohmann::ordered_json component_json(OwnerId id, std::string_view summary) {
  const auto about = model::summary_from_json(summary).value_or(Summary{});
  const auto blank = about.program.rfind(' ');  // `rubicon-proxy 0.1.0`
  nlohmann::ordered_json line;
  line["id"] = number(id);
  line["name"] = about.name;
  line["host"] = about.host;
  line["program"] = about.program.substr(0, blank);
  line["version"] = blank == std::string::npos ? "" : about.program.substr(blank + 1);
  if (model::is_island(id, about)) {
    line["prefix"] = about.prefix;
    line["networks"] = about.networks;
    line["devices"] = std::accumulate(about.networks.begin(), about.networks.end(), std::uint64_t{0},
                                      [](std::uint64_t sum, const auto& network) { return sum + network.second; });
  }
  line["since"] = base::to_seconds(about.since);
  return line;
}

nlohmann::ordered_json components_json(const TupleSpace& space, bool islands_only) {
  auto list = nlohmann::ordered_json::array();
  for (const auto id : space.peers()) {
    const auto summary = space.summary(id);
    const bool is_island = model::is_island(id, model::summary_from_json(summary).value_or(Summary{}));
    if (!islands_only || is_island) list.push_back(component_json(id, summary));
  }
  return list;
}

bool IslandPrefixes::fit(OwnerId owner, std::string_view key) {
  if (!model::is_island(owner)) return false;
  const auto [at, is_new] = beginnings_.try_emplace(owner);
  if (is_new) {
    const auto about = model::summary_from_json(space_.summary(owner)).value_or(Summary{});
    if (!about.prefix.empty()) at->second = about.prefix + ".";
  }
  return !at->second.empty() && key.starts_with(at->second);
}

}  // namespace rubicon::web::api
