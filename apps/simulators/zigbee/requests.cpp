#include "apps/simulators/zigbee/requests.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/simulators/zigbee/bridge_json.h"
#include "apps/simulators/zigbee/world.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Stage = RadioDevice::Stage;

/// What the record has after each answer of the device; the recorded bridge needed nine for a lamp.
constexpr std::array kStages{Stage::kEndpoints, Stage::kEndpoints, Stage::kModel, Stage::kManufacturer, Stage::kPower,
                             Stage::kPower,     Stage::kPower,     Stage::kDate,  Stage::kDate};
constexpr Duration kAnswer = 14ms;
constexpr int kAnswersBeforeFailure = 3;

}  // namespace

void Interviews::add(RadioDevice& device, bool fails) {
  if (state_.joining()) return begin(device, fails);
  waiting_.push_back({device.address(), fails});
}

void Interviews::open() {
  const auto waiting = std::exchange(waiting_, {});
  Duration after = kAnswer;
  for (const auto& one : waiting) {
    auto* device = registry_.find(one.address);
    if (device == nullptr) continue;
    delays_.after(*device, after, [this, fails = one.fails](RadioDevice& found) { begin(found, fails); });
    after += kAnswer;
  }
}

void Interviews::forget(const std::string& address) {
  std::erase_if(waiting_, [&](const auto& one) { return one.address == address; });
}

void Interviews::begin(RadioDevice& device, bool fails) {
  device.joined = true;
  topics_.availability(device);
  radio_.hear(device);
  topics_.devices();
  topics_.devices();
  topics_.event("device_joined", device);
  topics_.event("device_interview", device, {{"status", "started"}});
  delays_.after(device, kAnswer, [this, fails](RadioDevice& found) { ask(found, fails, 0); });
}

void Interviews::repeat(RadioDevice& device) {
  topics_.event("device_interview", device, {{"status", "started"}});
  delays_.after(device, kAnswer, [this](RadioDevice& found) { ask(found, false, 0); });
}

void Interviews::ask(RadioDevice& device, bool fails, int question) {
  radio_.hear(device);
  const bool known = device.usable();
  if (!known) device.set_stage(kStages[static_cast<std::size_t>(question)]);
  const int last = fails ? kAnswersBeforeFailure : static_cast<int>(kStages.size()) - 1;
  if (question < last)
    return delays_.after(device, kAnswer,
                         [this, fails, question](RadioDevice& found) { ask(found, fails, question + 1); });
  if (fails) return delays_.after(device, 10s, [this](RadioDevice& found) { fail_now(found); });
  succeed(device);
}

void Interviews::fail_now(RadioDevice& device) {
  device.set_stage(Stage::kFailed);
  topics_.devices();
  topics_.event("device_interview", device, {{"status", "failed"}});
}

void Interviews::succeed(RadioDevice& device) {
  if (!device.usable()) device.set_stage(Stage::kInterviewed);
  if (state_.options.nulls) device.know_nothing();
  topics_.devices();
  topics_.event("device_interview", device,
                {{"status", "successful"}, {"supported", true}, {"definition", device.definition()}});
  delays_.after(device, 100ms, [this](RadioDevice& found) { configure(found); });
}

void Interviews::configure(RadioDevice& device) {
  radio_.hear(device);
  const bool reports = !device.model().endpoints.begin()->at("configured_reportings").empty();
  if (reports && !device.model().sleeps) {
    for (const auto& properties : device.by_cluster(device.measured())) radio_.report(device, properties);
  }
  device.set_stage(Stage::kConfigured);
  topics_.devices();
  topics_.info();
  radio_.begin(device);
}

namespace {

using Json = nlohmann::json;

/// A map takes the bridge about half a second for each device [recorded with 15].
constexpr Duration kMapStep = 530ms;
/// Longest time for which joining can be permitted.
constexpr int kMaxJoin = 254;

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
  topics_.say(fmt::format("bridge/response/{}", what), model::dump(response));
}

void Requests::draw_map(const Json& request) {
  const auto type = model::text_of(request, "type");
  if (type != "raw")
    return respond("networkmap", request,
                   fail(ErrorCode::kInvalid, fmt::format("Type '{}' not supported, allowed are: raw", type)));
  const auto count = static_cast<int>(registry_.size());
  delays_.after(count * kMapStep, [this, request] {
    respond("networkmap", request, map_json(registry_.devices(), model::flag_of(request, "routes")));
  });
}

Result<RadioDevice*> Requests::device_of(const Json& request, const char* member) {
  const auto id = model::text_of(request, member);
  if (id.empty()) return wrong_payload();
  auto* device = registry_.find(id);
  if (device == nullptr || !device->joined)
    return fail(ErrorCode::kNotFound, fmt::format("Device '{}' does not exist", id));
  return device;
}

Result<DeviceGroup*> Requests::group_of(const Json& request, const char* member) {
  const auto id = text_or_number(request, member);
  if (id.empty()) return wrong_payload();
  auto* group = registry_.find_group(id);
  if (group == nullptr) return fail(ErrorCode::kNotFound, fmt::format("Group '{}' does not exist", id));
  return group;
}

Requests::Answer Requests::permit_join(const Json& request) {
  const auto time = request.find("time");
  if (time == request.end() || !time->is_number_integer()) return wrong_payload();
  const int seconds = time->get<int>();
  if (seconds < 0 || seconds > kMaxJoin)
    return fail(ErrorCode::kInvalid, fmt::format("Cannot permit join for more than {} seconds.", kMaxJoin));
  Json data{{"time", seconds}};
  if (const auto via = model::text_of(request, "device"); !via.empty()) {
    const auto router = device_of(request, "device");
    if (!router) return fail(router.error());
    data["device"] = via;
  }
  world_.permit_join(std::chrono::seconds(seconds));
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
  const auto name = (*device)->name();
  world_.forget(**device);
  topics_.say(name, "", true);
  topics_.groups();
  topics_.devices();
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
  state_.restart_required = state_.restart_required || changes->contains("qos") || changes->contains("retention");
  topics_.info();
  return Json{
      {"id", request["id"]}, {"from", from}, {"to", (*device)->options}, {"restart_required", state_.restart_required}};
}

Requests::Answer Requests::interview(const Json& request) {
  const auto device = device_of(request, "id");
  if (!device) return fail(device.error());
  if ((*device)->faults.silent)
    return fail(ErrorCode::kUnreachable, fmt::format("interview of '{}' ({}) failed: Error: no answer",
                                                     (*device)->name(), (*device)->address()));
  interviews_.repeat(**device);
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
  topics_.devices();
  return data;
}

Requests::Answer Requests::bridge_options(const Json& request) {
  const auto changes = request.find("options");
  if (changes == request.end() || !changes->is_object()) return wrong_payload();
  if (const auto advanced = changes->find("advanced"); advanced != changes->end()) {
    if (const auto last_seen = model::find_text(*advanced, "last_seen")) state_.options.last_seen = *last_seen;
    if (const auto output = model::find_text(*advanced, "output")) state_.options.output = *output;
  }
  if (changes->contains("availability")) state_.restart_required = true;
  topics_.info();
  return Json{{"restart_required", state_.restart_required}};
}

Requests::Answer Requests::add_group(const Json& request) {
  const auto name = model::text_of(request, "friendly_name");
  if (const auto allowed = registry_.check_name(name); !allowed) return fail(allowed.error());
  const int id = request.contains("id") && request["id"].is_number_integer() ? request["id"].get<int>() : 0;
  if (registry_.groups().contains(id))
    return fail(ErrorCode::kDuplicate, fmt::format("Group ID '{}' is already in use", id));
  const auto& group = registry_.add_group(id, name, {});
  topics_.groups();
  return Json{{"friendly_name", name}, {"id", group.id}};
}

Requests::Answer Requests::remove_group(const Json& request) {
  const auto group = group_of(request, "id");
  if (!group) return fail(group.error());
  const auto name = (*group)->name;
  registry_.erase_group((*group)->id);
  topics_.say(name, "", true);
  topics_.groups();
  return Json{{"id", request["id"]}, {"force", model::flag_of(request, "force")}};
}

Requests::Answer Requests::rename_group(const Json& request) {
  const auto group = group_of(request, "from");
  if (!group) return fail(group.error());
  const auto to = model::text_of(request, "to");
  if (const auto allowed = registry_.check_name(to); !allowed) return fail(allowed.error());
  const auto from = (*group)->name;
  registry_.rename_group(**group, to);
  topics_.say(from, "", true);
  topics_.groups();
  topics_.info();
  topics_.group(**group);
  return Json{{"from", from}, {"to", to}, {"homeassistant_rename", false}};
}

Requests::Answer Requests::add_member(const Json& request) {
  const auto group = group_of(request, "group");
  if (!group) return fail(group.error());
  const auto device = device_of(request, "device");
  if (!device) return fail(device.error());
  auto& members = (*group)->members;
  if (std::ranges::find(members, (*device)->address()) == members.end()) members.push_back((*device)->address());
  topics_.groups();
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
  topics_.groups();
  return Json{{"group", request["group"]}, {"device", request["device"]}};
}

Requests::Answer Requests::remove_from_all(const Json& request) {
  const auto device = device_of(request, "device");
  if (!device) return fail(device.error());
  for (auto& [id, group] : registry_.groups()) std::erase(group.members, (*device)->address());
  topics_.groups();
  return Json{{"device", request["device"]}};
}

Requests::Answer Requests::check_health(const Json&) {
  return Json{{"healthy", true}};
}

Requests::Answer Requests::check_coordinator(const Json&) {
  return Json{{"missing_routers", Json::array()}};
}

Requests::Answer Requests::restart(const Json&) {
  delays_.after(500ms, [this] { world_.restart(5s); });
  return Json::object();
}

}  // namespace rubicon::zigbee_simulator
