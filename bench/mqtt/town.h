#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "bridges/bridge.h"
#include "zigbee/real_rig.h"

namespace rubicon::bench::mqtt {

/// An island of devices with five sensors each, made of tuples, and a bridge to a real mosquitto.
class Town {
 public:
  Town(zigbee::RealRig& rig, int devices);

  void start_bridge();
  /// One reading of a sensor.
  void read(std::size_t sensor, std::string_view value);
  std::size_t sensors() const { return values_.size(); }
  std::string topic(std::size_t sensor) const { return topics_[sensor]; }
  TupleSpace& island() { return *island_; }
  bridges::Bridge& bridge() { return *bridge_; }
  static constexpr int kPoints = 5;

 private:
  void add_device(int number);

  zigbee::RealRig& rig_;
  base::NullLogSink log_;
  std::unique_ptr<tuples::Link> island_link_, bridge_link_;
  std::unique_ptr<TupleSpace> island_, space_;
  std::vector<tuples::TupleRef> values_, statuses_;
  std::vector<std::string> topics_;
  std::unique_ptr<bridges::Bridge> bridge_;
};

}  // namespace rubicon::bench::mqtt
