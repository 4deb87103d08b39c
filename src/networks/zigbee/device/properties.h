#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/by_text.h"
#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::device {

/// What is known of the value of a property.
struct KnownValue {
  std::string text{};     ///< JSON, as last taken; empty = never seen
  WallTime changed{};     ///< when the device had it first, as far as known
  bool unproven = false;  ///< an echo: the device did not report it yet
  bool stored = false;    ///< as Zigbee2MQTT remembered it at its start: a message that repeats it proves nothing
  bool due = false;       ///< shown as stale or stored: delivered once more when the device is heard
  bool asked = false;     ///< by a poll that was not answered yet
  SteadyTime asked_at{};  ///< zero = never
};

/// A property of the state messages of a device. Several points may share one: colour as x and y and as hue and
/// saturation.
struct Property : KnownValue {
  std::string name;
  std::vector<std::size_t> points;
  bool published = false, settable = false, gettable = false;
  bool event = false;        ///< each message counts once
  bool of_the_link = false;  ///< differs in each message, whatever caused it: no news of the other properties
};

/// The properties of a device by their JSON key.
class Properties {
 public:
  /// `before`: the points until now. What is known of a property is kept if its points are the same, so that the next
  /// message delivers the others; that its value is not proven is kept always. All indexes change.
  void set_points(const std::vector<exposes::MappedPoint>& before, const std::vector<exposes::MappedPoint>& points);

  /// nullptr if no point has this key.
  Property* find(std::string_view key);
  Property& operator[](std::size_t index) { return all_[index]; }
  std::size_t index_of(const Property& property) const { return static_cast<std::size_t>(&property - all_.data()); }
  std::size_t of_point(std::size_t point) const { return of_point_[point]; }
  std::vector<Property>& all() { return all_; }

 private:
  void add(const std::vector<exposes::MappedPoint>& points);

  std::vector<Property> all_;
  base::ByText<std::size_t> by_name_;
  std::vector<std::size_t> of_point_;
};

}  // namespace rubicon::networks::zigbee::device
