#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

/// Values of tuples as messages of ROS 2, and the other way round (docs/ros2.md, "Types").
namespace rubicon::bridges::ros2 {

enum class Form : std::uint8_t {
  kBool,
  kByte,
  kChar,
  kInt8,
  kUInt8,
  kInt16,
  kUInt16,
  kInt32,
  kUInt32,
  kInt64,
  kUInt64,
  kFloat32,
  kFloat64,
  kString,
  kTemperature,
  kRelativeHumidity,
  kIlluminance,
  kFluidPressure,
  kRange,
  kBatteryState,
  kNavSatFix,
  kDiagnosticArray,
  kPoseStamped,
  kPoseWithCovarianceStamped,
  kOdometry,
};

/// `sensor_msgs/msg/Temperature`
std::string_view type_of(Form form);
std::optional<Form> form_of(std::string_view ros_type);
/// What Cyclone DDS needs for a topic; lives as long as the program.
const dds_topic_descriptor_t& descriptor_of(Form form);

/// Lets a sequence of a message show the items while they live.
template <class Sequence, class Item>
void lend(Sequence& sequence, std::vector<Item>& items) {
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(items.size());
  sequence._buffer = items.data();
}

/// The form of the values of a point: sensors as sensor_msgs where there is one, everything else as std_msgs.
Form form_of_point(model::Kind kind, const model::PointDescription& about);
/// Whether a late reader gets the present value (states), or only new ones (readings, events).
bool is_state(model::Kind kind, const model::PointDescription& about);

/// A value on its way out.
struct Reading {
  std::string_view value;        ///< as in the tuple
  std::string_view longitude{};  ///< of kNavSatFix, whose latitude is the value
  std::string_view frame{};      ///< header.frame_id
  WallTime time{};               ///< header.stamp
};
/// Calls `use` with the message, which lives during the call. kInvalid for a value that does not fit.
Result<void> with_message(Form form, const model::PointDescription& about, const Reading& reading,
                          const std::function<void(const void* message)>& use);

/// One value in a message.
struct Part {
  std::string name;  ///< `voltage`; empty = the message is this value
  std::string type;  ///< of our catalogue
  std::string unit;  ///< UCUM code
  std::string value;
  std::string fault{};  ///< why there is no value; empty with an empty value = the sender does not measure it
};
struct Parts {
  WallTime stamp{};  ///< zero = the message has none, or one that cannot be
  std::vector<Part> all;
};
/// `message` as Cyclone DDS took it. The first kMaxStatuses of a kDiagnosticArray.
Parts parts_of(Form form, const void* message);
inline constexpr std::size_t kMaxStatuses = 64;
/// Of a text in a message, in bytes; longer ones are cut.
inline constexpr std::size_t kMaxImportedText = 4096;

/// The text for a command from a message of the form of its point.
std::string command_text(Form form, const model::PointDescription& about, const void* message);

}  // namespace rubicon::bridges::ros2
