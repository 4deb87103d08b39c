#include "apps/simulators/zigbee/requests.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/simulators/zigbee/bridge_json.h"
#include "apps/simulators/zigbee/interviews.h"
#include "model/json_members.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// A map takes the bridge about half a second for each device [recorded with 15].
constexpr Duration kMapStep = 530ms;
/// Longest time for which joining can be permitted.
constexpr int kLongestJoin = 254;

auto wrong_payload() {
  return fail(ErrorCode::kInvalid, "Invalid payload");
}

/// Text, or a number as text: groups are named by both.
std::string text_or_number(const Json& request, const char* member) {
  const auto found = request.find(member);
  if (found == request.end()) return {};
  return found->is_number_integer() ? std::to_string(found->get<int>()) : model::text_of(request, member);
}

}  // namespace

const std::map<std::string_view, Requests::Call>& Requests::calls() {
  static const std::map<std::string_view, Call> all{
      {"permit_join", &Requests::permit_join},
      {"device/rename", &Requests::rename_device},
      {"device/remove", &Requests::remove_device},
      {"device/options", &Requests::device_options},
      {"device/interview", &Requests::interview},
      {"device/reporting/configure", &Requests::configure_reporting},
      {"options", &Requests::bridge_options},
      {"group/add", &Requests::add_group},
      {"group/remove", &Requests::remove_group},
      {"group/rename", &Requests::rename_group},
      {"group/members/add", &Requests::add_member},
      {"group/members/remove", &Requests::remove_member},
      {"group/members/remove_all", &Requests::remove_from_all},
      {"health_check", &Requests::check_health},
      {"coordinator_check", &Requests::check_coordinator},
      {"restart", &Requests::restart},
  };
  return all;
}

void Requests::received(std::string_view what, std::string_view payload) {
  auto request = model::object_of(payload);
  if (what == "networkmap") return draw_map(request);
  const auto call = calls().find(what);
  if (call == calls().end()) return;
  respond(what, request, (this->*call->second)(request));
}

void Requests::respond(std::string_view what, const Json& request, const Answer& answer) {
  Json response{{"data", answer ? *answer : Json::object()}, {"status", answer ? "ok" : "error"}};
  if (!answer) response["error"] = answer.error().text;
  if (request.contains("transaction")) response["transaction"] = request["transaction"];
  world_.say(fmt::format("bridge/response/{}", what), model::dump(response));
}

void Requests::draw_map(const Json& request) {
  const auto type = model::text_of(request, "type");
  if (type != "raw")
    return respond("networkmap", request,
                   fail(ErrorCode::kInvalid, fmt::format("Type '{}' not supported, allowed are: raw", type)));
  const auto count = static_cast<int>(world_.devices_.size());
  world_.later(count * kMapStep, [this, request] {
    respond("networkmap", request, map_json(world_.devices(), model::flag_of(request, "routes")));
  });
}

Result<RadioDevice*> Requests::device_of(const Json& request, const char* member) {
  const auto id = model::text_of(request, member);
  if (id.empty()) return wrong_payload();
  auto* device = world_.find(id);
  if (device == nullptr || !device->joined)
    return fail(ErrorCode::kNotFound, fmt::format("Device '{}' does not exist", id));
  return device;
}

Result<DeviceGroup*> Requests::group_of(const Json& request, const char* member) {
  const auto id = text_or_number(request, member);
  if (id.empty()) return wrong_payload();
  auto* group = world_.find_group(id);
  if (group == nullptr) return fail(ErrorCode::kNotFound, fmt::format("Group '{}' does not exist", id));
  return group;
}

Requests::Answer Requests::permit_join(const Json& request) {
  const auto time = request.find("time");
  if (time == request.end() || !time->is_number_integer()) return wrong_payload();
  const int seconds = time->get<int>();
  if (seconds < 0 || seconds > kLongestJoin)
    return fail(ErrorCode::kInvalid, fmt::format("Cannot permit join for more than {} seconds.", kLongestJoin));
  Json data{{"time", seconds}};
  if (const auto via = model::text_of(request, "device"); !via.empty()) {
    const auto router = device_of(request, "device");
    if (!router) return fail(router.error());
    data["device"] = via;
  }
  world_.permit(std::chrono::seconds(seconds));
  return data;
}

Requests::Answer Requests::rename_device(const Json& request) {
  const auto device = device_of(request, "from");
  const auto to = model::find_text(request, "to");
  if (!to) return wrong_payload();
  if (!device) return fail(device.error());
  const auto from = (*device)->name();
  if (const auto renamed = world_.rename(**device, *to); !renamed) return fail(renamed.error());
  return Json{{"from", from}, {"to", *to}, {"homeassistant_rename", model::flag_of(request, "homeassistant_rename")}};
}

Requests::Answer Requests::remove_device(const Json& request) {
  const auto device = device_of(request, "id");
  if (!device) return fail(device.error());
  const bool force = model::flag_of(request, "force");
  if ((*device)->faults.silent && !force)
    return fail(
        ErrorCode::kUnreachable,
        fmt::format("Failed to remove device '{}' (block: false, force: false) (Error: ZDO leave failed: no answer)",
                    (*device)->name()));
  const auto gone = std::make_pair((*device)->address(), (*device)->name());
  world_.forget(gone.first);
  world_.say(gone.second, "", true);
  world_.publish_groups();
  world_.publish_devices();
  return Json{{"id", request["id"]},
              {"force", force},
              {"block", model::flag_of(request, "block")},
              {"keep_config", model::flag_of(request, "keep_config")}};
}

Requests::Answer Requests::device_options(const Json& request) {
  const auto device = device_of(request, "id");
  if (!device) return fail(device.error());
  const auto changes = request.find("options");
  if (changes == request.end() || !changes->is_object()) return wrong_payload();
  const auto from = (*device)->options;
  for (const auto& [name, value] : changes->items()) (*device)->options[name] = value;
  world_.restart_required_ = world_.restart_required_ || changes->contains("qos") || changes->contains("retention");
  world_.publish_info();
  return Json{{"id", request["id"]},
              {"from", from},
              {"to", (*device)->options},
              {"restart_required", world_.restart_required_}};
}

Requests::Answer Requests::interview(const Json& request) {
  const auto device = device_of(request, "id");
  if (!device) return fail(device.error());
  if ((*device)->faults.silent)
    return fail(ErrorCode::kUnreachable, fmt::format("interview of '{}' ({}) failed: Error: no answer",
                                                     (*device)->name(), (*device)->address()));
  world_.start_interview(**device);
  return Json{{"id", request["id"]}};
}

Requests::Answer Requests::configure_reporting(const Json& request) {
  const auto device = device_of(request, "id");
  if (!device) return fail(device.error());
  auto data = request;
  data.erase("transaction");
  for (const auto* member : {"cluster", "attribute", "minimum_report_interval", "maximum_report_interval"}) {
    if (!request.contains(member)) return wrong_payload();
  }
  world_.publish_devices();
  return data;
}

Requests::Answer Requests::bridge_options(const Json& request) {
  const auto changes = request.find("options");
  if (changes == request.end() || !changes->is_object()) return wrong_payload();
  if (const auto advanced = changes->find("advanced"); advanced != changes->end()) {
    if (const auto last_seen = model::find_text(*advanced, "last_seen")) world_.options_.last_seen = *last_seen;
    if (const auto output = model::find_text(*advanced, "output")) world_.options_.output = *output;
  }
  if (changes->contains("availability")) world_.restart_required_ = true;
  world_.publish_info();
  return Json{{"restart_required", world_.restart_required_}};
}

Requests::Answer Requests::add_group(const Json& request) {
  const auto name = model::text_of(request, "friendly_name");
  if (const auto allowed = world_.check_name(name); !allowed) return fail(allowed.error());
  const int id = request.contains("id") && request["id"].is_number_integer() ? request["id"].get<int>() : 0;
  if (world_.groups_.contains(id))
    return fail(ErrorCode::kDuplicate, fmt::format("Group ID '{}' is already in use", id));
  const auto& group = world_.add_group(id, name, {});
  world_.publish_groups();
  return Json{{"friendly_name", name}, {"id", group.id}};
}

Requests::Answer Requests::remove_group(const Json& request) {
  const auto group = group_of(request, "id");
  if (!group) return fail(group.error());
  const auto name = (*group)->name;
  world_.groups_.erase((*group)->id);
  if (world_.named) world_.named(name, false);
  world_.say(name, "", true);
  world_.publish_groups();
  return Json{{"id", request["id"]}, {"force", model::flag_of(request, "force")}};
}

Requests::Answer Requests::rename_group(const Json& request) {
  const auto group = group_of(request, "from");
  if (!group) return fail(group.error());
  const auto to = model::text_of(request, "to");
  if (const auto allowed = world_.check_name(to); !allowed) return fail(allowed.error());
  const auto from = std::exchange((*group)->name, to);
  if (world_.named) world_.named(from, false);
  if (world_.named) world_.named(to, true);
  world_.say(from, "", true);
  world_.publish_groups();
  world_.publish_info();
  world_.publish_group(**group);
  return Json{{"from", from}, {"to", to}, {"homeassistant_rename", false}};
}

Requests::Answer Requests::add_member(const Json& request) {
  const auto group = group_of(request, "group");
  if (!group) return fail(group.error());
  const auto device = device_of(request, "device");
  if (!device) return fail(device.error());
  auto& members = (*group)->members;
  if (std::ranges::find(members, (*device)->address()) == members.end()) members.push_back((*device)->address());
  world_.publish_groups();
  return Json{{"group", request["group"]},
              {"device", request["device"]},
              {"endpoint", request.contains("endpoint") ? request["endpoint"] : Json("default")}};
}

Requests::Answer Requests::remove_member(const Json& request) {
  const auto group = group_of(request, "group");
  if (!group) return fail(group.error());
  const auto device = device_of(request, "device");
  if (!device) return fail(device.error());
  std::erase((*group)->members, (*device)->address());
  world_.publish_groups();
  return Json{{"group", request["group"]}, {"device", request["device"]}};
}

Requests::Answer Requests::remove_from_all(const Json& request) {
  const auto device = device_of(request, "device");
  if (!device) return fail(device.error());
  for (auto& [id, group] : world_.groups_) std::erase(group.members, (*device)->address());
  world_.publish_groups();
  return Json{{"device", request["device"]}};
}

Requests::Answer Requests::check_health(const Json&) {
  return Json{{"healthy", true}};
}

Requests::Answer Requests::check_coordinator(const Json&) {
  return Json{{"missing_routers", Json::array()}};
}

Requests::Answer Requests::restart(const Json&) {
  world_.later(500ms, [this] { world_.restart(5s); });
  return Json::object();
}

}  // namespace rubicon::zigbee_simulator
