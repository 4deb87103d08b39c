#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/message.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx {

/// What the network needs of a GroupPoint while it runs; the rest would be half of what a list of 60,000 takes.
struct BoundGroup {
  wire::GroupAddress address{};
  std::optional<wire::GroupAddress> state{};
  std::optional<dpt::DptId> dpt{};
  std::string name{};
  groups::ReadRule read{};
};

/// A point with what follows from its GroupPoint.
struct BoundPoint {
  BoundGroup group;
  const dpt::Dpt* dpt = nullptr;  ///< nullptr: values are bytes in hex
  PointId id;
  std::string address;    ///< of its device within the network
  bool wanted = false;    ///< somebody subscribed to it
  SteadyTime heard_at{};  ///< of its last value; zero = not since the line came up

  /// Where its value is asked for.
  wire::GroupAddress source() const { return group.state.value_or(group.address); }
  /// It can be asked for at all: a sensor, or an actuator with a state address.
  bool readable() const { return id.kind == Kind::kSensor || group.state.has_value(); }
};

/// All points of a network, by device and by group address.
class PointTable {
 public:
  PointTable() = default;
  PointTable(const std::vector<groups::GroupPoint>& groups, const TypeCatalogue& types);

  struct Device {
    std::string name;  ///< empty: a device of one address, called as that, or one without a name
    std::vector<std::size_t> points;
  };
  /// By address within the network.
  const std::map<std::string, Device>& devices() const { return devices_; }
  std::vector<BoundPoint>& points() { return points_; }
  const std::vector<BoundPoint>& points() const { return points_; }

  /// A point whose value is heard on an address.
  struct Hearing {
    wire::GroupAddress address;
    std::uint32_t point;  ///< its index
  };
  /// In the order of the points; empty for an unknown address.
  std::span<const Hearing> heard_on(wire::GroupAddress address) const;
  /// The address means something here, also one that only takes commands.
  bool knows(wire::GroupAddress address) const;
  BoundPoint* find(const std::string& device, const PointId& id);
  /// Not heard: nobody spoke with the device yet.
  model::Join join_of(const std::string& device) const;

 private:
  void bind(const groups::GroupPoint& group, const TypeCatalogue& types);
  void sort();
  std::string place_of(const Device& device) const;

  const TypeCatalogue* types_ = nullptr;  ///< of a table with points
  std::vector<BoundPoint> points_;
  std::map<std::string, Device> devices_;
  std::map<std::string, std::string> wanted_ids_;  ///< of the devices that ask for another key part than their address
  std::vector<Hearing> heard_;                     ///< by address
  std::vector<wire::GroupAddress> commanded_;      ///< sorted: of actuators that are heard elsewhere
};

/// What a telegram says about a point, in the unit and words of the catalogue; an error names what was wrong.
Result<Value> value_of(const BoundPoint& point, wire::PayloadView payload);
/// The telegram's value of a command.
Result<wire::Payload> payload_of(const BoundPoint& point, const Value& value);

}  // namespace rubicon::networks::knx
