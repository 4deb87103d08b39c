#include "bridges/ros2/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

#include "base/text.h"
#include "ros_types.h"

namespace rubicon::bridges::ros2 {

namespace {

struct FormRow {
  std::string_view type;
  const dds_topic_descriptor_t* descriptor;
};

/// In the order of Form.
constexpr std::array kForms{
    FormRow{"std_msgs/msg/Bool", &std_msgs_msg_dds__Bool__desc},
    FormRow{"std_msgs/msg/Byte", &std_msgs_msg_dds__Byte__desc},
    FormRow{"std_msgs/msg/Char", &std_msgs_msg_dds__Char__desc},
    FormRow{"std_msgs/msg/Int8", &std_msgs_msg_dds__Int8__desc},
    FormRow{"std_msgs/msg/UInt8", &std_msgs_msg_dds__UInt8__desc},
    FormRow{"std_msgs/msg/Int16", &std_msgs_msg_dds__Int16__desc},
    FormRow{"std_msgs/msg/UInt16", &std_msgs_msg_dds__UInt16__desc},
    FormRow{"std_msgs/msg/Int32", &std_msgs_msg_dds__Int32__desc},
    FormRow{"std_msgs/msg/UInt32", &std_msgs_msg_dds__UInt32__desc},
    FormRow{"std_msgs/msg/Int64", &std_msgs_msg_dds__Int64__desc},
    FormRow{"std_msgs/msg/UInt64", &std_msgs_msg_dds__UInt64__desc},
    FormRow{"std_msgs/msg/Float32", &std_msgs_msg_dds__Float32__desc},
    FormRow{"std_msgs/msg/Float64", &std_msgs_msg_dds__Float64__desc},
    FormRow{"std_msgs/msg/String", &std_msgs_msg_dds__String__desc},
    FormRow{"sensor_msgs/msg/Temperature", &sensor_msgs_msg_dds__Temperature__desc},
    FormRow{"sensor_msgs/msg/RelativeHumidity", &sensor_msgs_msg_dds__RelativeHumidity__desc},
    FormRow{"sensor_msgs/msg/Illuminance", &sensor_msgs_msg_dds__Illuminance__desc},
    FormRow{"sensor_msgs/msg/FluidPressure", &sensor_msgs_msg_dds__FluidPressure__desc},
    FormRow{"sensor_msgs/msg/Range", &sensor_msgs_msg_dds__Range__desc},
    FormRow{"sensor_msgs/msg/BatteryState", &sensor_msgs_msg_dds__BatteryState__desc},
    FormRow{"sensor_msgs/msg/NavSatFix", &sensor_msgs_msg_dds__NavSatFix__desc},
    FormRow{"diagnostic_msgs/msg/DiagnosticArray", &diagnostic_msgs_msg_dds__DiagnosticArray__desc},
    FormRow{"geometry_msgs/msg/PoseStamped", &geometry_msgs_msg_dds__PoseStamped__desc},
    FormRow{"geometry_msgs/msg/PoseWithCovarianceStamped", &geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc},
    FormRow{"nav_msgs/msg/Odometry", &nav_msgs_msg_dds__Odometry__desc},
};
static_assert(kForms.size() == static_cast<std::size_t>(Form::kOdometry) + 1);

/// Sensors that have a message of their own, by type or unit.
struct SensorForm {
  std::string_view type, unit;
  Form form;
};
constexpr std::array kSensorForms{
    SensorForm{"", "Cel", Form::kTemperature},          SensorForm{"humidity", "%", Form::kRelativeHumidity},
    SensorForm{"", "lx", Form::kIlluminance},           SensorForm{"airPressure", "Pa", Form::kFluidPressure},
    SensorForm{"pressure", "Pa", Form::kFluidPressure}, SensorForm{"distance", "m", Form::kRange},
    SensorForm{"battery", "%", Form::kBatteryState},
};

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// As char*, which is how the C structs have texts that nobody changes.
char* c_text(const std::string& text) {
  return const_cast<char*>(text.c_str());
}

std_msgs_msg_dds__Header_ header_of(const Reading& reading, const std::string& frame) {
  const auto us = std::max<std::int64_t>(reading.time.time_since_epoch().count(), 0);
  std_msgs_msg_dds__Header_ header{};
  header.stamp.sec = static_cast<std::int32_t>(std::min<std::int64_t>(us / 1'000'000, 0x7fffffff));
  header.stamp.nanosec = static_cast<std::uint32_t>(us % 1'000'000 * 1000);
  header.frame_id = c_text(frame);
  return header;
}

Error unfit(std::string_view value, std::string_view expected) {
  return {ErrorCode::kInvalid, fmt::format("'{}' is not {}", value.substr(0, 60), expected)};
}

using Use = std::function<void(const void*)>;

template <class Message>
Result<void> with(const Message& message, const Use& use) {
  use(&message);
  return {};
}

Result<void> with_range(std_msgs_msg_dds__Header_ header, double value, const Use& use) {
  sensor_msgs_msg_dds__Range_ message{};
  message.header = header;
  message.range = static_cast<float>(value);
  return with(message, use);
}

Result<void> with_battery(std_msgs_msg_dds__Header_ header, double value, const Use& use) {
  std::string none;
  sensor_msgs_msg_dds__BatteryState_ message{};
  message.header = header;
  for (auto* unknown : {&message.voltage, &message.temperature, &message.current, &message.charge, &message.capacity,
                        &message.design_capacity})
    *unknown = kUnknown;
  message.percentage = static_cast<float>(value / 100);
  message.present = true;
  message.location = message.serial_number = none.data();
  return with(message, use);
}

Result<void> with_fix(std_msgs_msg_dds__Header_ header, double latitude, const Reading& reading, const Use& use) {
  const auto longitude = base::parse_number<double>(reading.longitude);
  if (!longitude) return fail(unfit(reading.longitude, "a longitude"));
  sensor_msgs_msg_dds__NavSatFix_ message{};
  message.header = header;
  message.latitude = latitude;
  message.longitude = *longitude;
  message.altitude = std::numeric_limits<double>::quiet_NaN();
  return with(message, use);
}

/// Of a number with a header and nothing else: header, value, variance.
Result<void> with_stamped(Form form, const Reading& reading, const Use& use) {
  const auto value = base::parse_number<double>(reading.value);
  if (!value || !std::isfinite(*value)) return fail(unfit(reading.value, "a number"));
  const std::string frame(reading.frame);
  const auto header = header_of(reading, frame);
  switch (form) {
    case Form::kRange: return with_range(header, *value, use);
    case Form::kBatteryState: return with_battery(header, *value, use);
    case Form::kNavSatFix: return with_fix(header, *value, reading, use);
    case Form::kRelativeHumidity: return with(sensor_msgs_msg_dds__RelativeHumidity_{header, *value / 100, 0}, use);
    default: break;
  }
  static_assert(sizeof(sensor_msgs_msg_dds__Temperature_) == sizeof(sensor_msgs_msg_dds__Illuminance_) &&
                sizeof(sensor_msgs_msg_dds__Temperature_) == sizeof(sensor_msgs_msg_dds__FluidPressure_));
  return with(sensor_msgs_msg_dds__Temperature_{header, *value, 0}, use);
}

template <class Message>
Result<void> with_number(std::string_view text, const char* expected, const Use& use) {
  const auto number = base::parse_number<decltype(Message::data)>(text);
  if (!number) return fail(unfit(text, expected));
  return with(Message{*number}, use);
}

/// Of a boolean: `off` and `on`, or the device's own words.
std::string word_of(const model::PointDescription& about, bool value) {
  if (about.words.size() < 2) return value ? "on" : "off";
  return about.words[value ? 1 : 0].text;
}

}  // namespace

std::string_view type_of(Form form) {
  return kForms[static_cast<std::size_t>(form)].type;
}

std::optional<Form> form_of(std::string_view ros_type) {
  const auto* const found =
      std::find_if(kForms.begin(), kForms.end(), [ros_type](const auto& row) { return row.type == ros_type; });
  if (found == kForms.end()) return std::nullopt;
  return static_cast<Form>(found - kForms.begin());
}

const dds_topic_descriptor_t& descriptor_of(Form form) {
  return *kForms[static_cast<std::size_t>(form)].descriptor;
}

Form form_of_point(model::Kind kind, const model::PointDescription& about) {
  const auto data = model::parse_data_type(about.data_type).value_or(model::DataType::kText);
  if (data == model::DataType::kBoolean) return Form::kBool;
  if (data == model::DataType::kInteger && about.type != "battery") return Form::kInt64;
  if (data != model::DataType::kReal && data != model::DataType::kInteger) return Form::kString;
  if (kind != model::Kind::kSensor) return Form::kFloat64;
  for (const auto& row : kSensorForms) {
    if ((row.type.empty() || row.type == about.type) && row.unit == about.unit) return row.form;
  }
  return Form::kFloat64;
}

bool is_state(model::Kind kind, const model::PointDescription& about) {
  if (about.report == "event") return false;
  const auto data = model::parse_data_type(about.data_type).value_or(model::DataType::kText);
  return kind != model::Kind::kSensor || (data != model::DataType::kReal && data != model::DataType::kInteger);
}

Result<void> with_message(Form form, const model::PointDescription& about, const Reading& reading, const Use& use) {
  switch (form) {
    case Form::kBool: return with(std_msgs_msg_dds__Bool_{reading.value == word_of(about, true)}, use);
    case Form::kInt64: return with_number<std_msgs_msg_dds__Int64_>(reading.value, "a whole number", use);
    case Form::kFloat64: return with_number<std_msgs_msg_dds__Float64_>(reading.value, "a number", use);
    case Form::kString: {
      const std::string text(reading.value);
      return with(std_msgs_msg_dds__String_{c_text(text)}, use);
    }
    default: return with_stamped(form, reading, use);
  }
}

namespace {

/// Seven digits are what a float has, 15 a double.
template <class Number>
std::string number_text(Number value) {
  if constexpr (std::is_same_v<Number, float>) return fmt::format("{:.7g}", value);
  return fmt::format("{:.15g}", value);
}

template <class Number>
Part part(std::string name, std::string type, std::string unit, Number value) {
  Part made{std::move(name), std::move(type), std::move(unit), {}};
  if constexpr (std::is_integral_v<Number>) {
    made.value = fmt::to_string(value);
  } else if (std::isfinite(value)) {
    made.value = number_text(value);
  } else if (!made.name.empty() && std::isnan(value)) {
    return made;
  } else {
    made.fault = std::isnan(value) ? "the message has no number (NaN)" : "the message has an infinite number";
  }
  return made;
}

std::string text_from(const char* text) {
  if (text == nullptr) return {};
  const std::string_view all(text, ::strnlen(text, kMaxImportedText));
  return std::string(all.substr(0, base::utf8_prefix(all)));
}

template <class Message>
const Message& as(const void* message) {
  return *static_cast<const Message*>(message);
}

template <class Message>
Part plain(const void* message) {
  return part("", "analogueInput", "1", as<Message>(message).data);
}

WallTime stamp_of(const std_msgs_msg_dds__Header_& header) {
  if (header.stamp.sec <= 0 || header.stamp.nanosec >= 1'000'000'000) return {};
  return WallTime(std::chrono::seconds(header.stamp.sec)) + std::chrono::microseconds(header.stamp.nanosec / 1000);
}

template <class Message>
Parts stamped(const void* message, const char* type, const char* unit, double Message::*value, double factor = 1) {
  const auto& from = as<Message>(message);
  return {stamp_of(from.header), {part("", type, unit, from.*value * factor)}};
}

Parts battery(const void* message) {
  const auto& from = as<sensor_msgs_msg_dds__BatteryState_>(message);
  return {stamp_of(from.header),
          {part("percentage", "battery", "%", from.percentage * 100), part("voltage", "voltage", "V", from.voltage),
           part("current", "current", "A", from.current), part("temperature", "temperature", "Cel", from.temperature)}};
}

Parts fix(const void* message) {
  const auto& from = as<sensor_msgs_msg_dds__NavSatFix_>(message);
  Parts parts{
      stamp_of(from.header),
      {part("latitude", "latitude", "deg", from.latitude), part("longitude", "longitude", "deg", from.longitude),
       part("altitude", "altitude", "m", from.altitude)}};
  if (from.status.status >= 0) return parts;
  for (auto& one : parts.all) {
    one.value.clear();
    one.fault = "the receiver has no fix";
  }
  return parts;
}

Parts pose(const std_msgs_msg_dds__Header_& header, const geometry_msgs_msg_dds__Pose_& from) {
  const auto& q = from.orientation;
  const auto yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
  return {stamp_of(header),
          {part("x", "length", "m", from.position.x), part("y", "length", "m", from.position.y),
           part("yaw", "angle", "deg", yaw * 180 / std::numbers::pi)}};
}

Parts diagnostics(const void* message) {
  constexpr std::array kLevels{"ok", "warning", "error", "stale"};
  const auto& from = as<diagnostic_msgs_msg_dds__DiagnosticArray_>(message);
  Parts parts{stamp_of(from.header), {}};
  for (std::uint32_t i = 0; i < std::min<std::size_t>(from.status._length, kMaxStatuses); ++i) {
    const auto& status = from.status._buffer[i];
    const auto said = text_from(status.message);
    const auto* const level = status.level < kLevels.size() ? kLevels[status.level] : "unknown";
    parts.all.push_back(
        {text_from(status.name), "text", "1", said.empty() ? level : fmt::format("{}: {}", level, said)});
  }
  return parts;
}

}  // namespace

Parts parts_of(Form form, const void* message) {
  switch (form) {
    case Form::kBool:
      return {{}, {{"", "digitalInput", "1", as<std_msgs_msg_dds__Bool_>(message).data ? "on" : "off"}}};
    case Form::kByte: return {{}, {plain<std_msgs_msg_dds__Byte_>(message)}};
    case Form::kChar: return {{}, {plain<std_msgs_msg_dds__Char_>(message)}};
    case Form::kInt8: return {{}, {plain<std_msgs_msg_dds__Int8_>(message)}};
    case Form::kUInt8: return {{}, {plain<std_msgs_msg_dds__UInt8_>(message)}};
    case Form::kInt16: return {{}, {plain<std_msgs_msg_dds__Int16_>(message)}};
    case Form::kUInt16: return {{}, {plain<std_msgs_msg_dds__UInt16_>(message)}};
    case Form::kInt32: return {{}, {plain<std_msgs_msg_dds__Int32_>(message)}};
    case Form::kUInt32: return {{}, {plain<std_msgs_msg_dds__UInt32_>(message)}};
    case Form::kInt64: return {{}, {plain<std_msgs_msg_dds__Int64_>(message)}};
    case Form::kUInt64: return {{}, {plain<std_msgs_msg_dds__UInt64_>(message)}};
    case Form::kFloat32: return {{}, {plain<std_msgs_msg_dds__Float32_>(message)}};
    case Form::kFloat64: return {{}, {plain<std_msgs_msg_dds__Float64_>(message)}};
    case Form::kString: return {{}, {{"", "text", "1", text_from(as<std_msgs_msg_dds__String_>(message).data)}}};
    case Form::kTemperature:
      return stamped(message, "temperature", "Cel", &sensor_msgs_msg_dds__Temperature_::temperature);
    case Form::kRelativeHumidity:
      return stamped(message, "humidity", "%", &sensor_msgs_msg_dds__RelativeHumidity_::relative_humidity, 100);
    case Form::kIlluminance: return stamped(message, "light", "lx", &sensor_msgs_msg_dds__Illuminance_::illuminance);
    case Form::kFluidPressure:
      return stamped(message, "pressure", "Pa", &sensor_msgs_msg_dds__FluidPressure_::fluid_pressure);
    case Form::kRange: {
      const auto& range = as<sensor_msgs_msg_dds__Range_>(message);
      return {stamp_of(range.header), {part("", "distance", "m", range.range)}};
    }
    case Form::kBatteryState: return battery(message);
    case Form::kNavSatFix: return fix(message);
    case Form::kDiagnosticArray: return diagnostics(message);
    case Form::kPoseStamped: {
      const auto& from = as<geometry_msgs_msg_dds__PoseStamped_>(message);
      return pose(from.header, from.pose);
    }
    case Form::kPoseWithCovarianceStamped: {
      const auto& from = as<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>(message);
      return pose(from.header, from.pose.pose);
    }
    case Form::kOdometry: {
      const auto& from = as<nav_msgs_msg_dds__Odometry_>(message);
      return pose(from.header, from.pose.pose);
    }
  }
  return {};
}

std::string command_text(Form form, const model::PointDescription& about, const void* message) {
  if (form == Form::kBool) return word_of(about, as<std_msgs_msg_dds__Bool_>(message).data);
  const auto parts = parts_of(form, message);
  return parts.all.empty() ? std::string() : parts.all.front().value;
}

}  // namespace rubicon::bridges::ros2
