#include "bridges/ros2/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ros_types.h"

namespace rubicon::bridges::ros2 {
namespace {

using ::testing::HasSubstr;

model::PointDescription about(const std::string& name) {
  static const model::TypeCatalogue kTypes;
  const auto* type = kTypes.find(name);
  model::PointDescription made;
  if (type == nullptr) return made;
  made.type = type->name;
  made.unit = type->unit;
  made.data_type = to_string(type->data);
  made.words = model::words_in(type->words);
  made.report = type->report == model::Report::kEvent ? "event" : "state";
  return made;
}

Form sensor_form(const std::string& type) {
  return form_of_point(model::Kind::kSensor, about(type));
}

/// What `read` finds in the message of a value; NaN: the value does not fit.
template <class Message, class Read>
double sent(Form form, const Reading& reading, Read read, const std::string& type = "temperature") {
  double found = std::numeric_limits<double>::quiet_NaN();
  std::ignore = with_message(form, about(type), reading, [&](const void* message) {
    found = static_cast<double>(read(*static_cast<const Message*>(message)));
  });
  return found;
}

TEST(Ros2Forms, SensorsHaveMessagesOfTheirOwnWhereThereAreSome) {
  EXPECT_EQ(sensor_form("temperature"), Form::kTemperature);
  EXPECT_EQ(sensor_form("dewPoint"), Form::kTemperature);
  EXPECT_EQ(sensor_form("humidity"), Form::kRelativeHumidity);
  EXPECT_EQ(sensor_form("light"), Form::kIlluminance);
  EXPECT_EQ(sensor_form("airPressure"), Form::kFluidPressure);
  EXPECT_EQ(sensor_form("distance"), Form::kRange);
  EXPECT_EQ(sensor_form("battery"), Form::kBatteryState);
  EXPECT_EQ(sensor_form("soilMoisture"), Form::kFloat64) << "not a relative humidity";
  EXPECT_EQ(sensor_form("stress"), Form::kFloat64) << "not a pressure of a fluid";
  EXPECT_EQ(sensor_form("power"), Form::kFloat64);
  EXPECT_EQ(sensor_form("windForce"), Form::kInt64);
  EXPECT_EQ(sensor_form("digitalInput"), Form::kBool);
  EXPECT_EQ(sensor_form("text"), Form::kString);
  EXPECT_EQ(sensor_form("batteryState"), Form::kString) << "words";
  EXPECT_EQ(form_of_point(model::Kind::kActuator, about("temperatureSetpoint")), Form::kFloat64);
}

TEST(Ros2Forms, StatesAreKeptForLateReadersAndReadingsAreNot) {
  EXPECT_FALSE(is_state(model::Kind::kSensor, about("temperature")));
  EXPECT_TRUE(is_state(model::Kind::kSensor, about("digitalInput")));
  EXPECT_TRUE(is_state(model::Kind::kActuator, about("temperatureSetpoint")));
  auto button = about("digitalInput");
  button.report = "event";
  EXPECT_FALSE(is_state(model::Kind::kSensor, button));
}

TEST(Ros2Forms, NamesOfTypesAreThoseOfRos) {
  EXPECT_EQ(type_of(Form::kOdometry), "nav_msgs/msg/Odometry");
  EXPECT_EQ(form_of("sensor_msgs/msg/Temperature"), Form::kTemperature);
  EXPECT_EQ(form_of("sensor_msgs/msg/Image"), std::nullopt);
  for (auto form = Form::kBool; form <= Form::kOdometry; form = static_cast<Form>(static_cast<int>(form) + 1)) {
    const std::string name(type_of(form));
    const auto package = name.substr(0, name.find('/')), last = name.substr(name.rfind('/') + 1);
    EXPECT_EQ(descriptor_of(form).m_typename, package + "::msg::dds_::" + last + "_");
    EXPECT_EQ(descriptor_of(form).type_information.sz, 0U) << "rmw has none";
  }
}

TEST(Ros2Messages, HaveTheUnitsOfRos) {
  const auto humidity = sent<sensor_msgs_msg_dds__RelativeHumidity_>(
      Form::kRelativeHumidity, {"55"}, [](const auto& message) { return message.relative_humidity; });
  EXPECT_DOUBLE_EQ(humidity, 0.55);
  const auto battery = sent<sensor_msgs_msg_dds__BatteryState_>(Form::kBatteryState, {"87"},
                                                                [](const auto& message) { return message.percentage; });
  EXPECT_FLOAT_EQ(static_cast<float>(battery), 0.87F);
  const auto voltage = sent<sensor_msgs_msg_dds__BatteryState_>(
      Form::kBatteryState, {"87"}, [](const auto& message) { return std::isnan(message.voltage) && message.present; });
  EXPECT_EQ(voltage, 1);
  const auto range = sent<sensor_msgs_msg_dds__Range_>(Form::kRange, {"1.5"}, [](const auto& message) {
    return message.range + message.min_range + message.max_range + message.field_of_view;
  });
  EXPECT_EQ(range, 1.5);
  const auto east = sent<sensor_msgs_msg_dds__NavSatFix_>(Form::kNavSatFix, {"59.27", "15.2"},
                                                          [](const auto& message) { return message.longitude; });
  EXPECT_EQ(east, 15.2);
}

TEST(Ros2Messages, HaveTheTimeOfTheValueAndTheDevice) {
  const Reading reading{"21.5", {}, "7", WallTime(std::chrono::microseconds(1'767'225'600'250'000))};
  EXPECT_EQ(sent<sensor_msgs_msg_dds__Temperature_>(Form::kTemperature, reading,
                                                    [](const auto& message) { return message.header.stamp.sec; }),
            1'767'225'600);
  EXPECT_EQ(sent<sensor_msgs_msg_dds__Temperature_>(Form::kTemperature, reading,
                                                    [](const auto& message) { return message.header.stamp.nanosec; }),
            250'000'000);
  EXPECT_EQ(
      sent<sensor_msgs_msg_dds__Temperature_>(
          Form::kTemperature, reading, [](const auto& message) { return std::string(message.header.frame_id) == "7"; }),
      1);
  const Reading early{"1", {}, {}, WallTime(std::chrono::seconds(-5))};
  EXPECT_EQ(sent<sensor_msgs_msg_dds__Temperature_>(Form::kTemperature, early,
                                                    [](const auto& message) { return message.header.stamp.sec; }),
            0);
}

TEST(Ros2Messages, KnowTheWordsOfADevice) {
  auto door = about("digitalInput");
  door.words = {{0, "closed"}, {1, "open"}};
  bool open = false;
  const auto read = [&](const void* message) { open = static_cast<const std_msgs_msg_dds__Bool_*>(message)->data; };
  ASSERT_TRUE(with_message(Form::kBool, door, {"open"}, read));
  EXPECT_TRUE(open);
  ASSERT_TRUE(with_message(Form::kBool, door, {"closed"}, read));
  EXPECT_FALSE(open);
  const std_msgs_msg_dds__Bool_ message{true};
  EXPECT_EQ(command_text(Form::kBool, door, &message), "open");
}

TEST(Ros2Messages, AreNotMadeOfWhatDoesNotFit) {
  const auto ignore = [](const void*) {};
  EXPECT_FALSE(with_message(Form::kTemperature, {}, {"warm"}, ignore));
  EXPECT_FALSE(with_message(Form::kTemperature, {}, {"nan"}, ignore));
  EXPECT_FALSE(with_message(Form::kFloat64, {}, {""}, ignore));
  EXPECT_FALSE(with_message(Form::kInt64, {}, {"1.5"}, ignore));
  EXPECT_FALSE(with_message(Form::kNavSatFix, {}, {"59.27", ""}, ignore));
}

std::string value_of(Form form, const void* message, std::size_t which = 0) {
  const auto parts = parts_of(form, message);
  return which < parts.all.size() ? parts.all[which].value : "(none)";
}

TEST(Ros2Parts, AreValuesInOurUnits) {
  const sensor_msgs_msg_dds__RelativeHumidity_ humidity{{}, 0.55, 0};
  EXPECT_EQ(value_of(Form::kRelativeHumidity, &humidity), "55");
  sensor_msgs_msg_dds__BatteryState_ battery{};
  battery.percentage = 0.87F;
  battery.voltage = 12.4F;
  battery.current = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(value_of(Form::kBatteryState, &battery), "87");
  EXPECT_EQ(value_of(Form::kBatteryState, &battery, 1), "12.4");
  EXPECT_EQ(value_of(Form::kBatteryState, &battery, 2), "") << "the robot does not measure it";
  EXPECT_EQ(parts_of(Form::kBatteryState, &battery).all[2].fault, "");
  const std_msgs_msg_dds__UInt64_ large{18'446'744'073'709'551'615U};
  EXPECT_EQ(value_of(Form::kUInt64, &large), "18446744073709551615");
}

TEST(Ros2Parts, OfAPoseAreItsPlaceAndItsDirection) {
  nav_msgs_msg_dds__Odometry_ odometry{};
  odometry.pose.pose.position = {1.5, -2, 0};
  odometry.pose.pose.orientation = {0, 0, std::sin(M_PI / 8), std::cos(M_PI / 8)};
  EXPECT_EQ(value_of(Form::kOdometry, &odometry), "1.5");
  EXPECT_EQ(value_of(Form::kOdometry, &odometry, 1), "-2");
  EXPECT_EQ(value_of(Form::kOdometry, &odometry, 2), "45");
}

TEST(Ros2Parts, NameWhatIsNoNumber) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const std_msgs_msg_dds__Float64_ message{bad};
    const auto parts = parts_of(Form::kFloat64, &message);
    EXPECT_EQ(parts.all[0].value, "");
    EXPECT_THAT(parts.all[0].fault, HasSubstr("number"));
  }
}

TEST(Ros2Parts, HaveNoTimeThatCannotBe) {
  sensor_msgs_msg_dds__Temperature_ message{};
  message.header.stamp = {1'767'225'600, 250'000'000};
  EXPECT_EQ(parts_of(Form::kTemperature, &message).stamp, WallTime(std::chrono::microseconds(1'767'225'600'250'000)));
  message.header.stamp = {-1, 0};
  EXPECT_EQ(parts_of(Form::kTemperature, &message).stamp, WallTime{});
  message.header.stamp = {1'767'225'600, 4'000'000'000};
  EXPECT_EQ(parts_of(Form::kTemperature, &message).stamp, WallTime{});
}

TEST(Ros2Parts, CutWhatIsTooLongOrNoText) {
  std::string text(100'000, 'x');
  const std_msgs_msg_dds__String_ message{text.data()};
  EXPECT_EQ(value_of(Form::kString, &message).size(), kMaxImportedText);
  std::string broken = "ab\xff";
  const std_msgs_msg_dds__String_ other{broken.data()};
  EXPECT_EQ(value_of(Form::kString, &other), "ab");
  EXPECT_EQ(value_of(Form::kString, std::array<std_msgs_msg_dds__String_, 1>{}.data()), "");
}

TEST(Ros2Parts, OfDiagnosticsAreTheirStatuses) {
  std::string name = "motor left", text = "hot", none;
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> statuses(
      100, {1, name.data(), text.data(), none.data(), {0, 0, nullptr, false}});
  statuses[1].level = 17;
  diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
  message.status = {100, 100, statuses.data(), false};
  const auto parts = parts_of(Form::kDiagnosticArray, &message);
  ASSERT_EQ(parts.all.size(), kMaxStatuses);
  EXPECT_EQ(parts.all[0].name, "motor left");
  EXPECT_EQ(parts.all[0].value, "warning: hot");
  EXPECT_EQ(parts.all[1].value, "unknown: hot");
}

}  // namespace
}  // namespace rubicon::bridges::ros2
