#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/message.h"
#include "networks/knx/groups/group_file.h"

namespace rubicon::networks::knx {

/// The part of a GroupPoint that the network needs at run time; the rest would double the memory of a list of 60,000.
struct BoundGroup {
  wire::GroupAddress address{};
  std::optional<wire::GroupAddress> state{};
  std::optional<dpt::DptId> dpt{};
  std::string name{}, state_name{};
  groups::ReadRule read{};
};

/// A point of the network, made from a GroupPoint.
struct BoundPoint {
  BoundGroup group;
  const dpt::Dpt* dpt = nullptr;  ///< nullptr: values are bytes in hex
  PointId id;
  std::string address;  ///< of its device within the network
  std::shared_ptr<const std::vector<model::Word>>
      scenes{};  ///< groups::scene_words(); nullptr: its scenes have no names
  bool subscribed = false;
  SteadyTime updated_at{};  ///< of its last value; zero = none since the line came up

  /// The address that reports its value and is read.
  wire::GroupAddress source() const { return group.state.value_or(group.address); }
  /// True for sensors and for actuators with a state address: the others have no value on the bus.
  bool readable() const { return id.kind == Kind::kSensor || group.state.has_value(); }
};

/// All points of a network, by device and by group address.
class PointTable {
 public:
  PointTable() = default;
  /// `notation`: of the addresses in texts for people.
  PointTable(const std::vector<groups::GroupPoint>& groups, const TypeCatalogue& types,
             wire::Notation notation = wire::Notation::kThreeLevel);

  struct Device {
    std::string name;  ///< empty: not configured, or the device is a single group address
    std::string room;  ///< of all its points that have one; empty = of none, or they differ
    bool several_rooms = false;
    std::vector<std::size_t> points;
  };
  /// By their address within the network.
  const std::map<std::string, Device>& devices() const { return devices_; }
  std::vector<BoundPoint>& points() { return points_; }
  const std::vector<BoundPoint>& points() const { return points_; }

  /// A point that takes values from a group address.
  struct Listener {
    wire::GroupAddress address;
    std::uint32_t point;  ///< its index in points()
  };
  /// In the order of the points.
  std::span<const Listener> listeners_of(wire::GroupAddress address) const;
  /// True if a point takes values from the address or sends commands to it.
  bool contains(wire::GroupAddress address) const;
  /// The tuple of the actuator that takes commands from the address: `actuator.switch-1.command of device 1/4/6`. Also
  /// of one that only listens there: its device may well take them (a central function). Empty: there is none.
  std::string command_at(wire::GroupAddress address) const;
  BoundPoint* find(const std::string& device, const PointId& id);
  /// `heard` is false: no telegram of the device was received yet.
  model::Join join_of(const std::string& device) const;

 private:
  void bind(const groups::GroupPoint& group, const TypeCatalogue& types);
  void sort();
  const BoundPoint* commanded_by(wire::GroupAddress address) const;
  std::string model_of(const Device& device) const;

  const TypeCatalogue* types_ = nullptr;  ///< not null in a table with points
  wire::Notation notation_ = wire::Notation::kThreeLevel;
  std::vector<BoundPoint> points_;
  std::map<std::string, Device> devices_;
  std::map<std::string, std::string> wanted_ids_;      ///< key parts by device, where its address is taken
  std::vector<Listener> listeners_;                    ///< sorted by address
  std::vector<wire::GroupAddress> command_addresses_;  ///< of actuators with a state address, sorted
};

/// The value in a telegram, in the unit and words of the type catalogue. An error names what is wrong with the payload.
Result<Value> value_of(const BoundPoint& point, wire::PayloadView payload);
/// The payload of a command with this value (in the catalogue's unit and words). kInvalid, kOutOfRange: the type cannot
/// hold it.
Result<wire::Payload> payload_of(const BoundPoint& point, const Value& value);

}  // namespace rubicon::networks::knx
