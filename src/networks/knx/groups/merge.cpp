#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "networks/knx/groups/group_file.h"

namespace rubicon::networks::knx::groups {

namespace {

class Merge {
 public:
  Merge(std::vector<GroupPoint> known, const std::vector<GroupPoint>& imported, Report& report)
      : points_(std::move(known)),
        report_(report),
        has_rooms_(
            std::any_of(imported.begin(), imported.end(), [](const auto& point) { return !point.room.empty(); })) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      owner_.try_emplace(points_[i].address, i);
      if (points_[i].state) states_.insert(*points_[i].state);
    }
    known_ = points_.size();
  }

  void take(const GroupPoint& imported) {
    seen_.insert(imported.address);
    if (imported.state) seen_.insert(*imported.state);
    if (const auto found = owner_.find(imported.address); found != owner_.end()) {
      update(points_[found->second], imported);
    } else if (states_.contains(imported.address)) {
      take_state(imported);
    } else {
      add(imported);
    }
  }

  std::vector<GroupPoint> finish() {
    for (std::size_t i = 0; i < known_; ++i) {
      const auto& point = points_[i];
      if (!seen_.contains(point.address)) {
        ++report_.vanished;
        report_.warning(0, point.address, fmt::format("'{}' is no longer in the import: kept", point.name));
      }
      if (point.state && !seen_.contains(*point.state)) {
        report_.warning(0, point.address,
                        fmt::format("its state address {} is no longer in the import: kept",
                                    to_string(*point.state, report_.notation)));
      }
    }
    std::stable_sort(points_.begin(), points_.end(),
                     [](const auto& a, const auto& b) { return a.address < b.address; });
    return std::move(points_);
  }

 private:
  bool is_taken(wire::GroupAddress address) const { return owner_.contains(address) || states_.contains(address); }

  void update(GroupPoint& point, const GroupPoint& imported) {
    const auto before = point;
    point.name = imported.name;
    point.description = imported.description;
    update_room(point, imported);
    point.main_group = imported.main_group;
    point.middle_group = imported.middle_group;
    if (imported.state && imported.state == point.state) point.state_name = imported.state_name;
    if (point.name != before.name) {
      ++report_.renamed;
      report_.note(0, point.address, fmt::format("'{}' is now '{}': its id is kept", before.name, point.name));
    } else {
      ++report_.unchanged;
    }
    if (imported.dpt != point.dpt)
      report_.note(0, point.address,
                   fmt::format("the import has {}, the group file {}: the latter is kept", type_text(imported.dpt),
                               type_text(point.dpt)));
    if (imported.kind != point.kind)
      report_.note(0, point.address,
                   fmt::format("the import makes it {}, the group file {}: the latter is kept",
                               kind_text(imported.kind), kind_text(point.kind)));
    if (imported.state && imported.state != point.state) adopt_state(point, imported);
  }

  /// Only projects have rooms: without one the room of the group file may be written by hand.
  void update_room(GroupPoint& point, const GroupPoint& imported) {
    if (!imported.room.empty()) {
      point.room = imported.room;
    } else if (!point.room.empty() && has_rooms_) {
      report_.note(0, point.address, fmt::format("the import has no room for it: '{}' is kept", point.room));
    }
  }

  /// Uses a new state address: for the actuator if it has none, else as a sensor.
  void adopt_state(GroupPoint& point, const GroupPoint& imported) {
    const auto state = *imported.state;
    if (is_taken(state)) {
      report_.note(0, point.address,
                   fmt::format("the import pairs it with {}, which the group file uses elsewhere: "
                               "the group file is kept",
                               to_string(state, report_.notation)));
      return;
    }
    if (point.kind == Kind::kActuator && !point.state) {
      point.state = state;
      point.state_name = imported.state_name;
      states_.insert(state);
      report_.note(0, point.address, fmt::format("new state address: {}", to_string(state, report_.notation)));
      return;
    }
    auto sensor = imported;
    sensor.address = state;
    sensor.state.reset();
    sensor.name = sensor.state_name.empty() ? sensor.name : std::exchange(sensor.state_name, {});
    sensor.listen.clear();
    sensor.kind = Kind::kSensor;
    add(sensor);
  }

  /// The address is a point in the import and a state address in the group file. Only its own state address is new.
  void take_state(const GroupPoint& imported) {
    ++report_.unchanged;
    if (!imported.state || is_taken(*imported.state)) return;
    auto other = imported;
    other.kind = Kind::kSensor;
    adopt_state(other, imported);
  }

  void add(const GroupPoint& imported) {
    auto point = imported;
    if (point.state && is_taken(*point.state)) {
      report_.note(0, point.address,
                   fmt::format("not paired with {}: the group file uses it elsewhere",
                               to_string(*point.state, report_.notation)));
      point.state.reset();
      point.state_name.clear();
    }
    if (point.state) states_.insert(*point.state);
    owner_.try_emplace(point.address, points_.size());
    ++report_.added;
    report_.note(0, point.address, fmt::format("new: '{}'", point.name));
    points_.push_back(std::move(point));
  }

  static std::string_view kind_text(Kind kind) { return kind == Kind::kActuator ? "an actuator" : "a sensor"; }
  static std::string type_text(std::optional<dpt::DptId> type) {
    return type ? "type " + to_string(*type) : std::string("no type");
  }

  std::vector<GroupPoint> points_;
  std::size_t known_ = 0;
  Report& report_;
  const bool has_rooms_;                                       ///< the import is of a project
  std::unordered_map<wire::GroupAddress, std::size_t> owner_;  ///< address -> its point
  std::unordered_set<wire::GroupAddress> states_, seen_;
};

}  // namespace

std::vector<GroupPoint> merge(std::vector<GroupPoint> known, const std::vector<GroupPoint>& imported, Report& report) {
  report.merged = true;
  Merge merge(std::move(known), imported, report);
  for (const auto& point : imported) merge.take(point);
  return merge.finish();
}

}  // namespace rubicon::networks::knx::groups
