#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/deadline.h"
#include "proxy/device_directory.h"
#include "proxy/memory.h"

namespace rubicon::proxy {

/// Keeps the tuples of devices and their points true (docs/tuple-keys.md). Status texts that only say "heard again"
/// wait for a flush, at most one a second; a changed quality is published at once.
class TupleMirror {
 public:
  TupleMirror(ProxyContext& context, DeviceDirectory& directory, Memory& memory);

  /// After a join: makes what is missing, deletes what vanished, describes what changed.
  void joined(const DeviceDirectory::Joined& joined);
  void left(Device& device);
  /// Takes a device's tuples away before it gets other keys; what they held is for renamed().
  struct Kept {
    std::string value, media_type;
    WallTime user_time{};
  };
  std::map<PointNumber, Kept> retire(Device& device);
  /// The device has its new keys: makes its tuples again, as they were.
  void renamed(Device& device, const std::map<PointNumber, Kept>& kept);
  /// Only the device's name changed.
  void described(const Device& device);
  /// The last value a point had before the island was restarted. Only where nothing is known yet.
  void remembered(const Device& device, Point& point, const state::StoredValue& stored);
  /// One point made outside a join.
  void added(Device& device, Point& point);

  void device_status(const Device& device);
  /// The line or the device changed: the quality shown of all its points does.
  void all_points(Device& device);

  /// A value arrived. True if the point just became good, so that its deadline must be watched.
  bool reading(Device& device, Point& point, const model::Reading& reading);
  /// A value nobody reported: commanded to an actuator that cannot report.
  void assume(const Device& device, Point& point, const Value& value);
  /// A value the proxy itself is the source of (`rate`), or that a network knew at the join.
  void own_value(const Device& device, Point& point, const Value& value, Quality quality);

  void set_quality(const Device& device, Point& point, Quality quality, std::string reason);
  void publish_status(const Device& device, Point& point);

  enum class Role : std::uint8_t { kValue, kCommand };
  struct Place {
    Role role = Role::kValue;
    DeviceNumber device = 0;
    PointNumber point = 0;
  };
  /// Which point one of our tuples belongs to.
  std::optional<Place> place_of(TupleRef tuple) const;

 private:
  void declare_device(Device& device);
  void declare_point(Device& device, Point& point, const Kept* kept = nullptr);
  void erase_point(const Device& device, const Point& point);
  void initial_value(const Device& device, Point& point);
  TupleRef declare(std::string_view key, std::string_view value, std::string_view media_type, WallTime user_time = {});
  void remember(TupleRef tuple, Place place);
  void bad_value(const Device& device, Point& point, const std::string& why);
  void store_value(Point& point, const Value& value, WallTime user_time);
  void mark(Device& device, Point& point);
  void ask_flush(bool at_once);
  void flush();

  struct Known {
    std::uint32_t generation = 0;
    Place place;
  };

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Memory& memory_;
  std::unordered_map<std::uint32_t, Known> places_;  ///< by TupleRef::index
  std::vector<DeviceNumber> dirty_, flushing_;
  base::Deadline next_flush_;
  SteadyTime last_flush_{};
  bool urgent_ = false;  ///< a line or device changed since the flush began
  std::string value_text_, status_text_;
};

}  // namespace rubicon::proxy
