#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "proxy/device_directory.h"
#include "proxy/memory.h"

namespace rubicon::proxy {

inline constexpr Duration kEventLasts = std::chrono::seconds(2);

/// Publishes the tuples of devices and their points (docs/tuple-keys.md). A status whose only news is the time of the
/// last reading waits for a flush, at most one per second; a changed quality is published at once.
///
/// An event (a button, a scene: docs/types.md) is not a present value: kEventLasts after it came its tuple is empty
/// again, so that who subscribes later, or returns, does not take it for news. `heard` in the status says when the last
/// one came.
class TupleMirror {
 public:
  TupleMirror(ProxyContext& context, DeviceDirectory& directory, Memory& memory);

  /// After a join: declares new tuples, erases those of vanished points, updates descriptions.
  void joined(const DeviceDirectory::Joined& joined);
  /// Erases the tuples of the device.
  void left(Device& device);
  /// Erases the tuples before the device gets other keys. Pass the returned values to renamed().
  struct Kept {
    std::string value, media_type;
    WallTime user_time{};
  };
  std::map<PointNumber, Kept> retire(Device& device);
  /// The device has its new keys: declares its tuples again with the values they had.
  void renamed(Device& device, const std::map<PointNumber, Kept>& kept);
  /// The name or area of the device changed.
  void described(const Device& device);
  /// The value of a point before the island was restarted. Ignored if a newer one is known.
  void remembered(const Device& device, Point& point, const state::StoredValue& stored);
  /// A point was added outside a join.
  void added(Device& device, Point& point);

  void device_status(const Device& device);
  /// The line or the device changed, and with it the shown quality of all its points.
  void all_points(Device& device);

  /// What reading() touches comes into the cache meanwhile.
  void fetch(const Point& point) const;
  /// Publishes a value that arrived. True if the point just became good: its deadline must be watched.
  bool reading(Device& device, Point& point, const model::Reading& reading);
  /// A value that its network remembers (Updates::heard is false): shown as stored, unless a newer one is known.
  void repeated(const Device& device, Point& point, const model::Reading& reading);
  /// A value that was commanded to an actuator that cannot report.
  void assume(const Device& device, Point& point, const Value& value);
  /// A value whose source is the proxy (`rate`), or that came with the join.
  void own_value(const Device& device, Point& point, const Value& value, Quality quality);

  void set_quality(const Device& device, Point& point, Quality quality, std::string reason);
  void publish_status(const Device& device, Point& point);

  /// The point whose value or command an own tuple is; device and point are nullptr if it is neither.
  struct Place {
    Device* device = nullptr;
    Point* point = nullptr;
    bool is_command = false;
  };
  Place place_of(TupleRef tuple) const;

 private:
  void declare_device(Device& device);
  void declare_point(Device& device, Point& point, const Kept* kept = nullptr);
  void erase_point(const Device& device, const Point& point);
  void initial_value(const Device& device, Point& point);
  TupleRef declare(std::string_view key, std::string_view value, std::string_view media_type, WallTime user_time = {});
  void remember(TupleRef tuple, const Device& device);
  bool believes(const Device& device, Point& point, const Value& value);
  void bad_value(const Device& device, Point& point, const std::string& why);
  void refuse(const Device& device, Point& point, const std::string& why);
  bool is_news(const Device& device, const Point& point, const model::Reading& reading) const;
  void store_value(const Device& device, Point& point, const Value& value, WallTime user_time);
  void end_later(const Device& device, const Point& point);
  void end_events();
  void mark(Device& device, Point& point);
  void schedule_flush(bool at_once);
  void flush();

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Memory& memory_;
  std::vector<std::uint32_t> places_;  ///< of the device (DeviceNumber) by TupleRef::index; may be of a former tuple
  std::vector<DeviceNumber> dirty_, flushing_;
  std::map<std::pair<DeviceNumber, PointNumber>, SteadyTime> events_;  ///< that are present, and when they are over
  base::Deadline event_end_;
  base::Deadline next_flush_;
  SteadyTime last_flush_{};
  bool urgent_ = false;  ///< a line or device changed: the next flush must not wait
  std::string value_text_, status_text_;
};

}  // namespace rubicon::proxy
