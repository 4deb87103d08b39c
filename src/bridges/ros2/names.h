#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Names on both sides: keys of tuples, ROS names, and what they are for DDS (docs/ros2.md; design.ros2.org, "Topic and
/// Service name mapping to DDS").
namespace rubicon::bridges::ros2 {

/// Of a ROS name, in bytes, such that distinct_name() and `/outcome` fit behind it; rmw takes 247.
inline constexpr std::size_t kMaxName = 230;

/// One token of a ROS name: other characters than `[A-Za-z0-9_]` become `_`, and of several `_` remains one. What then
/// begins with a digit, or with `_`, which ROS hides in lists, gets `d` in front: `1-4-6` -> `d1_4_6`. Never empty.
std::string token(std::string_view text);

/// Absolute, tokens of `[A-Za-z0-9_]+` that begin with no digit, at most 247 bytes.
bool is_ros_name(std::string_view name);

/// `/home/wsn_1/d7/temperature_1` from `home` and the key `proxy.wsn-1.7.sensor.temperature-1`. Cut at kMaxName.
std::string ros_name(std::string_view name_space, std::string_view point_key);

/// `/x/y` -> `rt/x/y`.
std::string dds_topic(std::string_view ros_name);
/// The other way round; nullopt for what is no ROS topic, such as services.
std::optional<std::string> topic_of_dds(std::string_view topic);
/// `sensor_msgs::msg::dds_::Temperature_` -> `sensor_msgs/msg/Temperature`; nullopt for what is no ROS message.
std::optional<std::string> type_of_dds(std::string_view type);

/// Where `import: auto` puts a topic: `/r1/imu/temperature` -> device `r1`, instance `imu_temperature`; a name of one
/// token -> device `robot`. Parts of a key.
struct ImportPlace {
  std::string device, instance;
};
ImportPlace import_place(std::string_view ros_name);

/// Of several points that want one name none has it: each gets a number of eight hexadecimal digits behind it, which
/// depends on nothing but its own id (owner and key), so that names are the same after each start.
std::string distinct_name(std::string_view wanted, std::string_view id);

}  // namespace rubicon::bridges::ros2
