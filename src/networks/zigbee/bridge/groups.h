#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "networks/zigbee/bridge/device_record.h"

namespace rubicon::networks::zigbee::bridge {

/// A record of `bridge/groups` (zigbee.md, section 7).
struct Group {
  std::uint32_t id = 0;
  std::string name, description;
  std::vector<std::string> members;  ///< addresses of devices, each once, in the order of the record
  std::string unusable_name{};       ///< as DeviceRecord::unusable_name
  std::string address() const { return "group-" + std::to_string(id); }
  friend bool operator==(const Group&, const Group&) = default;
};

struct GroupList {
  std::vector<Group> groups;         ///< without the bridge's own group for bindings
  std::vector<std::string> skipped;  ///< why records were left out
};

/// kInvalid if it is not an array of records.
Result<GroupList> read_groups(std::string_view payload);

/// `[{"address":"group-7","members":["00124b0010000001"]}]`, at most kMaxMembersText bytes: further groups are left
/// out.
std::string members_to_json(const std::vector<Group>& groups);
inline constexpr std::size_t kMaxMembersText = std::size_t{64} << 10U;

using FindDevice = std::function<const DeviceRecord*(const std::string& address)>;

/// The differences after a new list of groups, or after a change of members.
struct GroupChanges {
  std::vector<DeviceRecord> changed;  ///< new, or different in any way
  std::vector<std::string> left;      ///< addresses
};

/// The groups as devices: each has the light, switch and cover leaves that at least one member lets us set, with the
/// widest bounds. Members that are not found add nothing. A group is never asked for its state.
class Groups {
 public:
  GroupChanges replace(std::vector<Group> groups, const FindDevice& find);
  /// `members`: addresses of devices that are new or gone, or whose leaves changed. Only their groups are rebuilt.
  GroupChanges members_changed(const std::set<std::string>& members, const FindDevice& find);
  /// A list came.
  bool arrived() const { return arrived_; }
  /// Who belongs to which group, by addresses: JSON (members_to_json).
  const std::string& members() const { return members_; }
  /// By address.
  const std::map<std::string, DeviceRecord>& records() const { return records_; }

 private:
  void rebuild(const Group& group, const FindDevice& find, GroupChanges& changes);

  std::vector<Group> groups_;
  std::string members_ = "[]";
  bool arrived_ = false;
  std::map<std::string, DeviceRecord> records_;
};

}  // namespace rubicon::networks::zigbee::bridge
