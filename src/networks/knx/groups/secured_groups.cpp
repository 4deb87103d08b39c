#include "networks/knx/groups/secured_groups.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "networks/knx/groups/encoding.h"

namespace rubicon::networks::knx::groups {

std::vector<wire::GroupAddress> read_secured_groups(ConfigReader& reader) {
  std::set<wire::GroupAddress> found;
  for (const auto& text : reader.texts("secured-groups")) {
    const auto address = wire::parse_group(text);
    address ? void(found.insert(*address)) : reader.error("secured-groups", address.error().text);
  }
  return {found.begin(), found.end()};
}

std::vector<wire::GroupAddress> secured_of(const GroupList& list) {
  std::set<wire::GroupAddress> found;
  for (const auto& entry : list.entries) {
    if (entry.secured) found.insert(entry.address);
  }
  return {found.begin(), found.end()};
}

std::vector<wire::GroupAddress> merge_secured(const std::vector<wire::GroupAddress>& known, const GroupList& imported,
                                              Report& report) {
  std::set<wire::GroupAddress> all(known.begin(), known.end());
  for (const auto& entry : imported.entries) {
    if (entry.secured && all.insert(entry.address).second)
      report.note(0, entry.address, "secured from now on: its key is in the keyring");
    const bool is_plain = !entry.secured && (imported.knows_plain || to_lower(entry.security) == "off");
    if (is_plain && all.erase(entry.address) != 0)
      report.warning(0, entry.address, "no longer secured: plain telegrams are sent and taken");
  }
  return {all.begin(), all.end()};
}

std::vector<wire::GroupAddress> joined(const std::vector<wire::GroupAddress>& one,
                                       const std::vector<wire::GroupAddress>& other) {
  std::vector<wire::GroupAddress> all;
  std::set_union(one.begin(), one.end(), other.begin(), other.end(), std::back_inserter(all));
  return all;
}

}  // namespace rubicon::networks::knx::groups
