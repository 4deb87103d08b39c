#include "networks/zigbee/bridge/device_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/text.h"
#include "networks/zigbee/bridge/json_tree.h"
#include "transport/mqtt.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

constexpr std::size_t kMaxReportings = 256;

Role read_role(const std::string& type) {
  if (type == "Coordinator") return Role::kCoordinator;
  if (type == "Router") return Role::kRouter;
  // Green power devices only send; they have no mains.
  if (type == "EndDevice" || type == "GreenPower") return Role::kEndDevice;
  return Role::kUnknown;
}

/// The two booleans are what bridges before 2.0 had instead of interview_state.
Interview read_interview(const JsonObject& record) {
  const auto state = text_at(record, "interview_state");
  if (state == "SUCCESSFUL") return Interview::kSuccessful;
  if (state == "FAILED") return Interview::kFailed;
  if (state == "IN_PROGRESS") return Interview::kInProgress;
  if (!state.empty()) return Interview::kPending;
  if (flag_at(record, "interviewing").value_or(false)) return Interview::kInProgress;
  return flag_at(record, "interview_completed").value_or(false) ? Interview::kSuccessful : Interview::kPending;
}

void read_reportings(const JsonObject& endpoint, std::vector<Reporting>& out) {
  const auto list = array_at(endpoint, "configured_reportings");
  if (!list) return;
  for (const auto item : *list) {
    JsonObject reporting;
    if (item.get(reporting) || out.size() >= kMaxReportings) continue;
    out.push_back({word_at(reporting, "cluster"), word_at(reporting, "attribute"),
                   small_count_at(reporting, "minimum_report_interval"),
                   small_count_at(reporting, "maximum_report_interval")});
  }
}

void read_endpoints(const JsonObject& record, std::vector<Reporting>& out) {
  const auto endpoints = object_at(record, "endpoints");
  if (!endpoints) return;
  for (const auto field : *endpoints) {
    JsonObject endpoint;
    if (!field.value.get(endpoint)) read_reportings(endpoint, out);
  }
}

Result<void> read_definition(const JsonObject& definition, DeviceRecord& record) {
  record.vendor = text_at(definition, "vendor");
  record.model = text_at(definition, "model");
  if (record.description.empty()) record.description = text_at(definition, "description");
  if (const auto options = array_at(definition, "options")) {
    std::vector<std::string> texts;
    for (const auto option : *options) {
      if (texts.size() < kMaxOptions) texts.push_back(simdjson::to_string(option));
    }
    record.options = std::move(texts);
  }
  const auto exposes = json_at(definition, "exposes");
  if (exposes.empty()) return {};
  auto leaves = exposes::read_exposes(exposes, record.skipped);
  if (!leaves) return fail(leaves.error());
  record.leaves = std::move(*leaves);
  return {};
}

void read_identity(const JsonObject& object, DeviceRecord& record) {
  record.role = read_role(text_at(object, "type"));
  record.interview = read_interview(object);
  record.disabled = flag_at(object, "disabled").value_or(false);
  record.vendor = text_at(object, "manufacturer");
  record.model = text_at(object, "model_id");
  record.description = text_at(object, "description");
  record.firmware = text_at(object, "software_build_id");
  record.power_source = text_at(object, "power_source");
  if (record.power_source == "Unknown") record.power_source.clear();
}

/// The base topic has as many at most; together they stay below the 200 that mosquitto takes.
constexpr std::ptrdiff_t kMaxNameLevels = 90;

}  // namespace

bool DeviceRecord::mains() const {
  if (power_source.empty()) return role == Role::kRouter;
  return power_source != "Battery";
}

std::string address_of(std::string_view ieee) {
  if (ieee.size() != 18 || !ieee.starts_with("0x")) return {};
  std::string address(ieee.substr(2));
  for (auto& digit : address) {
    const auto byte = static_cast<unsigned char>(digit);
    if (std::isxdigit(byte) == 0) return {};
    digit = static_cast<char>(std::tolower(byte));
  }
  return address;
}

std::string ieee_of(std::string_view address) {
  return "0x" + std::string(address);
}

std::string name_problem(std::string_view name) {
  if (name.empty()) return "the friendly name is empty";
  if (name.size() > kMaxTextBytes) return fmt::format("the friendly name has more than {} bytes", kMaxTextBytes);
  if (!base::is_utf8(name)) return "the friendly name is no UTF-8";
  if (name.find_first_of("+#") != name.npos) return "the friendly name has a wildcard of MQTT (+ or #)";
  if (!transport::is_mqtt_text(name)) return "the friendly name has control characters or noncharacters of Unicode";
  if (std::ranges::count(name, '/') >= kMaxNameLevels)
    return fmt::format("the friendly name has more than {} levels", kMaxNameLevels);
  if (name.front() == '/' || name.back() == '/') return "the friendly name begins or ends with a slash";
  return {};
}

std::string why_waiting(const DeviceRecord& record) {
  if (!record.unusable_name.empty())
    return fmt::format("{}; rename it: rubicon zigbee rename {} NAME", record.unusable_name, record.address);
  if (record.disabled) return "disabled in Zigbee2MQTT; enable it there";
  switch (record.interview) {
    case Interview::kPending: return "the interview has not started; wake the device up, for example by its button";
    case Interview::kInProgress: return "the interview is in progress; keep the device awake and near until it ends";
    case Interview::kFailed:
      return "the interview failed; wake the device up near the coordinator and interview it again in Zigbee2MQTT, or "
             "remove it and pair it again";
    case Interview::kSuccessful: break;
  }
  if (record.supported) return {};
  return fmt::format(
      "Zigbee2MQTT does not support the model '{}' of '{}'; update Zigbee2MQTT, or add an external "
      "converter to it",
      base::one_line(record.model), base::one_line(record.vendor));
}

Result<DeviceRecord> read_device_record(std::string_view json) {
  JsonTree tree;
  const auto object = tree.parse_object(json, "device record", kMaxRecordBytes);
  if (!object) return fail(object.error());
  DeviceRecord record;
  record.address = address_of(text_at(*object, "ieee_address"));
  if (record.address.empty())
    return fail(ErrorCode::kInvalid, "device record: no ieee_address of 0x and 16 hexadecimal digits");
  const auto name = member(*object, "friendly_name");
  std::string_view spelled;
  if (!name || name->get(spelled)) spelled = {};
  record.name = text_at(*object, "friendly_name");
  record.unusable_name = name_problem(spelled);
  read_identity(*object, record);
  read_endpoints(*object, record.reportings);
  const auto definition = object_at(*object, "definition");
  record.supported = flag_at(*object, "supported").value_or(definition.has_value());
  if (!definition) return record;
  if (auto read = read_definition(*definition, record); !read)
    return fail(ErrorCode::kInvalid, fmt::format("device 0x{}: {}", record.address, read.error().text));
  return record;
}

}  // namespace rubicon::networks::zigbee::bridge
