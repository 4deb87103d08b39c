#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::console {

struct LiveNetwork {
  std::string id, line, reason;
};

struct LiveDevice {
  std::string key, network, id, name, status, reason;
};

struct LivePoint {
  std::string key, id, value, unit, quality, command;
  WallTime heard{};  ///< zero = never
};

/// What a live table shows, read from the copies that a component has of an island's tuples.
class LiveSource {
 public:
  LiveSource(const TupleSpace& space, OwnerId island, std::string prefix);

  /// By id.
  std::vector<LiveNetwork> networks() const;
  /// Keys (`proxy.wsn-1.7`) by network and device; numbers in them count as numbers.
  std::vector<std::string> devices() const;
  LiveDevice device(const std::string& key) const;
  /// Keys (`proxy.wsn-1.7.sensor.light-1`) of a device: sensors first, then actuators.
  std::vector<std::string> points(const std::string& device) const;
  LivePoint point(const std::string& key) const;

  struct Count {
    std::size_t devices = 0, reachable = 0;
  };
  Count count() const;
  /// A command line of the shell that changes something.
  std::string command_to_try() const;

 private:
  model::DeviceKey any_device() const;
  std::string value(const std::string& key) const;
  model::PointDescription description(const model::PointKey& point) const;

  const TupleSpace& space_;
  OwnerId island_;
  std::string prefix_;
};

}  // namespace rubicon::console
