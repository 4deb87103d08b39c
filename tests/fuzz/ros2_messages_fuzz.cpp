#include <cstdlib>
#include <cstring>

#include "base/bytes.h"
#include "base/text.h"
#include "bridges/ros2/messages.h"
#include "fuzz_target.h"
#include "ros_types.h"

namespace rubicon::fuzz::ros2_messages_fuzz {

namespace {

using namespace bridges::ros2;

/// Any numbers; texts, which Cyclone DDS guarantees to end, of the rest.
template <class Message>
Message filled(ByteView bytes) {
  Message message{};
  if (!bytes.empty()) std::memcpy(static_cast<void*>(&message), bytes.data(), std::min(bytes.size(), sizeof message));
  return message;
}

void check(Form form, const void* message) {
  static const model::TypeCatalogue kTypes;
  const auto parts = parts_of(form, message);
  if (parts.all.size() > kMaxStatuses || parts.stamp < WallTime{}) std::abort();
  for (const auto& part : parts.all) {
    const auto* type = kTypes.find(std::string_view(part.type));
    if (type == nullptr || part.value.size() > kMaxImportedText + 16 || !base::is_utf8(part.value)) std::abort();
    if (!part.fault.empty() && !part.value.empty()) std::abort();
    if (type->data == model::DataType::kReal && !part.value.empty() && !base::parse_number<double>(part.value))
      std::abort();
  }
  const auto text = command_text(form, {}, message);
  if (form == Form::kBool && text != "on" && text != "off") std::abort();
}

template <class Message>
void check_plain(Form form, ByteView bytes) {
  const auto message = filled<Message>(bytes);
  check(form, &message);
}

template <class Message>
void check_stamped(Form form, ByteView bytes, std::string text) {
  auto message = filled<Message>(bytes);
  message.header.frame_id = text.data();
  if constexpr (std::is_same_v<Message, sensor_msgs_msg_dds__BatteryState_>) {
    message.present = true;
    message.location = message.serial_number = text.data();
    message.cell_voltage = message.cell_temperature = {};
  }
  if constexpr (std::is_same_v<Message, nav_msgs_msg_dds__Odometry_>) message.child_frame_id = text.data();
  check(form, &message);
}

void check_diagnostics(ByteView bytes, std::string text) {
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> statuses(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    statuses[i] = {bytes[i], text.data() + i % (text.size() + 1), text.data(), text.data(), {}};
  auto message = filled<diagnostic_msgs_msg_dds__DiagnosticArray_>({});
  message.header.frame_id = text.data();
  message.status = {static_cast<std::uint32_t>(statuses.size()), static_cast<std::uint32_t>(statuses.size()),
                    statuses.data(), false};
  check(Form::kDiagnosticArray, &message);
}

/// What is sent must be understood alike.
void check_sent(std::string_view value) {
  for (const auto form : {Form::kBool, Form::kInt64, Form::kFloat64, Form::kTemperature, Form::kRelativeHumidity,
                          Form::kBatteryState, Form::kRange, Form::kNavSatFix}) {
    std::ignore = with_message(form, {}, {value, value, value, WallTime::max()},
                               [form](const void* message) { check(form, message); });
  }
}

}  // namespace

/// Input: one octet for the form, then the members as they lie in memory.
FUZZ_TARGET(ros2_messages) {
  if (size == 0) return 0;
  const ByteView bytes(data + 1, size - 1);
  const std::string text(base::as_text(bytes));
  check_sent(text.substr(0, 40));
  switch (data[0] % 12) {
    case 0: check_plain<std_msgs_msg_dds__Int64_>(Form::kInt64, bytes); break;
    case 1: check_plain<std_msgs_msg_dds__UInt64_>(Form::kUInt64, bytes); break;
    case 2: check_plain<std_msgs_msg_dds__Float32_>(Form::kFloat32, bytes); break;
    case 3: check_plain<std_msgs_msg_dds__Float64_>(Form::kFloat64, bytes); break;
    case 4: check_stamped<sensor_msgs_msg_dds__Temperature_>(Form::kTemperature, bytes, text); break;
    case 5: check_stamped<sensor_msgs_msg_dds__RelativeHumidity_>(Form::kRelativeHumidity, bytes, text); break;
    case 6: check_stamped<sensor_msgs_msg_dds__Range_>(Form::kRange, bytes, text); break;
    case 7: check_stamped<sensor_msgs_msg_dds__BatteryState_>(Form::kBatteryState, bytes, text); break;
    case 8: check_stamped<sensor_msgs_msg_dds__NavSatFix_>(Form::kNavSatFix, bytes, text); break;
    case 9: check_stamped<nav_msgs_msg_dds__Odometry_>(Form::kOdometry, bytes, text); break;
    case 10: check_diagnostics(bytes, text); break;
    default: {
      std::string copy = text;
      const std_msgs_msg_dds__String_ message{copy.data()};
      check(Form::kString, &message);
    }
  }
  return 0;
}

}  // namespace rubicon::fuzz::ros2_messages_fuzz
