#include "networks/zigbee/bridge/groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "model/json_text.h"
#include "networks/zigbee/bridge/json_tree.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

constexpr std::size_t kMaxGroupBytes = std::size_t{4} * 1024 * 1024;
/// Of all groups together: each change of a member rebuilds its groups.
constexpr std::size_t kMaxGroups = 1000, kMaxMembers = 5000;
constexpr std::size_t kMaxSkippedTexts = 20, kMaxGroupLeaves = 256;
/// The bridge uses it for bindings of its own (zigbee.md, section 7).
constexpr std::string_view kBindGroup = "default_bind_group";

void read_members(const JsonObject& object, Group& group) {
  const auto members = array_at(object, "members");
  if (!members) return;
  std::set<std::string> known;
  for (const auto item : *members) {
    JsonObject member;
    if (item.get(member) || known.size() >= kMaxMembers) continue;
    auto address = address_of(text_at(member, "ieee_address"));
    if (!address.empty() && known.insert(address).second) group.members.push_back(std::move(address));
  }
}

Result<Group> read_group(const JsonElement& element) {
  JsonObject object;
  if (element.get(object)) return fail(ErrorCode::kInvalid, "bridge/groups: a record is not an object");
  Group group;
  group.id = small_count_at(object, "id");
  group.name = text_at(object, "friendly_name");
  group.description = text_at(object, "description");
  if (group.id == 0) return fail(ErrorCode::kInvalid, "bridge/groups: a record has no id above 0");
  group.unusable_name = name_problem(group.name);
  read_members(object, group);
  return group;
}

bool for_groups(const exposes::Leaf& leaf) {
  return leaf.access.settable && (leaf.group == "light" || leaf.group == "switch" || leaf.group == "cover");
}

/// The leaf as the group has it: its topics know no endpoints, and a group is not asked.
exposes::Leaf without_endpoint(exposes::Leaf leaf) {
  const auto suffix = "_" + leaf.endpoint;
  if (!leaf.endpoint.empty() && leaf.property.ends_with(suffix))
    leaf.property.resize(leaf.property.size() - suffix.size());
  leaf.endpoint.clear();
  leaf.access.gettable = false;
  return leaf;
}

/// A member without the bound takes every value.
template <class Before>
std::optional<double> wider(std::optional<double> one, std::optional<double> other, Before before) {
  if (!one || !other) return std::nullopt;
  return before(*one, *other) ? one : other;
}

void widen(exposes::Leaf& leaf, const exposes::Leaf& other) {
  leaf.access.published = leaf.access.published || other.access.published;
  leaf.minimum = wider(leaf.minimum, other.minimum, std::less<>());
  leaf.maximum = wider(leaf.maximum, other.maximum, std::greater<>());
  leaf.step = wider(leaf.step, other.step, std::less<>());
  for (const auto& value : other.values) {
    if (std::ranges::find(leaf.values, value.json, &exposes::NamedValue::json) == leaf.values.end())
      leaf.values.push_back(value);
  }
}

/// `state` of a lamp and `state` of a switch are one; `color_xy` and `color_hs` share a property and are two.
bool same_in_group(const exposes::Leaf& one, const exposes::Leaf& other) {
  return one.property == other.property && one.name == other.name && one.form == other.form;
}

void add_leaf(std::vector<exposes::Leaf>& leaves, exposes::Leaf leaf) {
  const auto known = std::ranges::find_if(leaves, [&](const auto& other) { return same_in_group(leaf, other); });
  if (known == leaves.end()) {
    if (leaves.size() < kMaxGroupLeaves) leaves.push_back(std::move(leaf));
    return;
  }
  // With one lamp among switches the group is a lamp.
  if (known->group != "light" && leaf.group == "light") std::swap(*known, leaf);
  widen(*known, leaf);
}

DeviceRecord group_record(const Group& group, const FindDevice& find) {
  DeviceRecord record;
  record.address = group.address();
  record.name = group.name;
  record.unusable_name = group.unusable_name;
  record.interview = Interview::kSuccessful;
  record.supported = true;
  record.vendor = "Zigbee2MQTT";
  record.model = "group";
  record.description = group.description;
  std::vector<exposes::Leaf> leaves;
  for (const auto& member : group.members) {
    const auto* device = find(member);
    if (device == nullptr) continue;
    for (const auto& leaf : device->leaves) {
      if (for_groups(leaf)) add_leaf(leaves, without_endpoint(leaf));
    }
  }
  record.leaves = std::move(leaves);
  return record;
}

}  // namespace

Result<GroupList> read_groups(std::string_view payload) {
  JsonTree tree;
  const auto root = tree.parse(payload, "bridge/groups", kMaxGroupBytes);
  if (!root) return fail(root.error());
  JsonArray records;
  if (root->get(records)) return fail(ErrorCode::kInvalid, "bridge/groups: no JSON array");
  GroupList list;
  std::set<std::uint32_t> ids;
  std::size_t members = 0;
  const auto skip = [&](std::string why) {
    if (list.skipped.size() < kMaxSkippedTexts) list.skipped.push_back(std::move(why));
  };
  for (const auto element : records) {
    auto group = read_group(element);
    if (!group) {
      skip(group.error().text);
    } else if (list.groups.size() >= kMaxGroups) {
      skip(fmt::format("bridge/groups: more than {} groups", kMaxGroups));
      break;
    } else if (group->name == kBindGroup) {
      continue;
    } else if (!ids.insert(group->id).second) {
      skip(fmt::format("group {}: is there twice", group->id));
    } else if (members += group->members.size(); members > kMaxMembers) {
      skip(fmt::format("bridge/groups: more than {} members of groups", kMaxMembers));
      break;
    } else {
      list.groups.push_back(std::move(*group));
    }
  }
  return list;
}

std::string members_to_json(const std::vector<Group>& groups) {
  auto list = nlohmann::json::array();
  std::size_t bytes = 0;
  for (const auto& group : groups) {
    nlohmann::json one{{"address", group.address()}, {"members", group.members}};
    bytes += model::dump(one).size() + 1;
    if (bytes >= kMaxMembersText) break;
    list.push_back(std::move(one));
  }
  return model::dump(list);
}

GroupChanges Groups::replace(std::vector<Group> groups, const FindDevice& find) {
  groups_ = std::move(groups);
  members_ = members_to_json(groups_);
  arrived_ = true;
  GroupChanges changes;
  std::set<std::string> present;
  for (const auto& group : groups_) {
    present.insert(group.address());
    rebuild(group, find, changes);
  }
  for (const auto& [address, record] : records_) {
    if (!present.contains(address)) changes.left.push_back(address);
  }
  for (const auto& address : changes.left) records_.erase(address);
  return changes;
}

GroupChanges Groups::members_changed(const std::set<std::string>& members, const FindDevice& find) {
  GroupChanges changes;
  for (const auto& group : groups_) {
    const auto has = [&](const auto& member) { return members.contains(member); };
    if (std::ranges::any_of(group.members, has)) rebuild(group, find, changes);
  }
  return changes;
}

void Groups::rebuild(const Group& group, const FindDevice& find, GroupChanges& changes) {
  auto record = group_record(group, find);
  auto& known = records_[record.address];
  if (known == record) return;
  known = std::move(record);
  changes.changed.push_back(known);
}

}  // namespace rubicon::networks::zigbee::bridge
