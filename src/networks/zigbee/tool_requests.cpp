#include "networks/zigbee/tool_requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/json_members.h"
#include "model/message_fields.h"
#include "networks/zigbee/bridge/settings.h"
#include "networks/zigbee/bridge/topics.h"
#include "networks/zigbee/device_options.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

using namespace std::chrono_literals;
using nlohmann::json;

/// Bound of the list in a reply, so that it fits one message.
constexpr std::size_t kMaxReplyBytes = 100'000;
constexpr std::size_t kMaxRequestText = 512;
/// Zigbee2MQTT's longest time (zigbee.md, section 8).
constexpr std::int64_t kMaxPermit = 254;
constexpr std::string_view kTooManyWatch = "too many tools watch devices join";

std::string request_text(const json& request, const char* key) {
  return model::text_of(request, key).substr(0, kMaxRequestText);
}

std::string_view word(bridge::Role role) {
  switch (role) {
    case bridge::Role::kCoordinator: return "coordinator";
    case bridge::Role::kRouter: return "router";
    case bridge::Role::kEndDevice: return "end device";
    case bridge::Role::kUnknown: break;
  }
  return "unknown";
}

std::string_view word(bridge::Interview interview) {
  switch (interview) {
    case bridge::Interview::kPending: return "pending";
    case bridge::Interview::kInProgress: return "in progress";
    case bridge::Interview::kSuccessful: return "successful";
    case bridge::Interview::kFailed: break;
  }
  return "failed";
}

json settings_json(const bridge::BridgeDescription& info) {
  auto settings = json::array();
  for (const auto& one : bridge::recommendations(info))
    settings.push_back({{"setting", one.setting}, {"is", one.is}, {"should", one.should}, {"why", one.why}});
  return settings;
}

json bridge_json(const bridge::BridgeDescription& info) {
  json out{{"version", info.version},
           {"coordinator", info.coordinator},
           {"channel", info.channel},
           {"permit_join", info.permit_join},
           {"restart_required", info.restart_required}};
  if (!info.coordinator_address.empty()) out["coordinator_address"] = info.coordinator_address;
  if (info.permit_join_end != WallTime{}) out["permit_join_end"] = base::to_seconds(info.permit_join_end);
  return out;
}

}  // namespace

std::string_view tag_of(const json& request) {
  const auto what = request_text(request, "do");
  const bool changes =
      what == "permit" || what == "rename" || what == "remove" || (what == "options" && request.contains("set"));
  return changes ? kAdminTag : kRequestTag;
}

ToolRequests::ToolRequests(network::NetworkHost& host, std::string requester, const DeviceTable& devices,
                           Publish publish, std::function<std::string()> trouble)
    : host_(host),
      requester_(std::move(requester)),
      devices_(devices),
      publish_(std::move(publish)),
      trouble_(std::move(trouble)),
      down_("Zigbee2MQTT is not there yet"),
      monitors_(host) {}

void ToolRequests::use(bool up, const std::string& why) {
  down_ = up ? std::string() : why;
  if (up) return;
  for (const auto& open : std::exchange(open_, {})) refuse(open.requester, why);
  close_watching(why);
}

void ToolRequests::not_taken(std::string_view topic, const std::string& why) {
  std::list<Open> refused;
  for (auto at = open_.begin(); at != open_.end();) {
    const auto one = at++;
    if (topic.ends_with("/bridge/request/" + one->what)) refused.splice(refused.end(), open_, one);
  }
  for (const auto& open : refused) refuse(open.requester, why);
}

Result<void> ToolRequests::receive(const Message& message) {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (!opaque || (opaque->type != kRequestTag && opaque->type != kAdminTag))
    return fail(ErrorCode::kUnsupported, fmt::format("ZigBee does not support {}", to_string(message.kind())));
  if (!message.destination.device.empty())
    return fail(ErrorCode::kRefused,
                fmt::format("a {} concerns the whole network: address that, not a device", opaque->type));
  const auto object = model::read_tool_request(*opaque);
  if (!object) return fail(object.error());
  const auto& request = *object;
  Requester requester{message.source, request_text(request, "id")};
  if (opaque->type != kAdminTag && tag_of(request) == kAdminTag) {
    refuse(requester, fmt::format("this request needs a message of the type {}", kAdminTag));
  } else {
    answer(std::move(requester), request);
  }
  return {};
}

void ToolRequests::answer(Requester requester, const json& request) {
  const auto what = request_text(request, "do");
  if (what == "devices") {
    devices(requester, request);
  } else if (what == "monitor") {
    monitor(requester, request);
  } else if (!down_.empty()) {
    refuse(requester, down_);
  } else if (what == "permit") {
    permit(std::move(requester), request);
  } else if (what == "rename") {
    rename(std::move(requester), request);
  } else if (what == "remove") {
    remove(std::move(requester), request);
  } else if (what == "options") {
    options(std::move(requester), request);
  } else if (what == "map") {
    map(std::move(requester), request);
  } else if (what == "health") {
    health_check(std::move(requester));
  } else {
    refuse(requester, fmt::format("do is {}, expected permit, devices, rename, remove, options, map, health or monitor",
                                  model::quoted(what)));
  }
}

void ToolRequests::monitor(const Requester& requester, const json& request) {
  if (auto done = monitors_.ask(requester.address, requester.id, request); !done)
    return refuse(requester, done.error().text);
  reply(requester, {{"ok", true}, {"line", down_.empty()}});
}

/// The lists and settings of the bridge are no traffic, and long: those who watch see their length.
void ToolRequests::passed(std::string_view topic, std::string_view payload, bool outgoing) {
  if (!monitors_.any()) return;
  constexpr std::array<std::string_view, 3> kLong{"bridge/info", "bridge/devices", "bridge/groups"};
  json out{{"time", base::to_seconds(host_.scheduler().wall_now())},
           {"direction", outgoing ? "out" : "in"},
           {"topic", topic},
           {"bytes", payload.size()}};
  const bool is_long = std::find(kLong.begin(), kLong.end(), topic) != kLong.end();
  if (!is_long) out["text"] = payload.substr(0, kMaxShown);
  monitors_.send(kMessageTag, model::dump(out));
}

/// The answer carries the transaction of the request (zigbee.md, section 8).
void ToolRequests::ask(Requester requester, std::string_view what, json payload, Duration time, Done done) {
  if (open_.size() >= kMaxOpen) return refuse(requester, "too many requests are open");
  if (last_transaction_ == 0)  // other than those of an earlier run
    last_transaction_ = static_cast<std::uint64_t>(host_.scheduler().wall_now().time_since_epoch().count());
  auto transaction = fmt::format("rubicon-{}-{}", requester_, ++last_transaction_);
  payload["transaction"] = transaction;
  if (auto sent = publish_(what, model::dump(payload)); !sent) return refuse(requester, sent.error().text);
  auto& added =
      open_.emplace_back(Open{std::move(requester), std::string(what), std::move(transaction), std::move(done), {}});
  added.timeout = host_.scheduler().after(time, [this, &added, time] {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time).count();
    refuse(added.requester, fmt::format("Zigbee2MQTT did not answer within {} s", seconds));
    open_.remove_if([&](const Open& one) { return &one == &added; });
  });
}

void ToolRequests::response(std::string_view payload) {
  if (open_.empty()) return;  // of another client
  const auto response = bridge::read_response(payload);
  if (!response || response->transaction.empty()) return;
  const auto found = std::find_if(open_.begin(), open_.end(),
                                  [&](const Open& one) { return one.transaction == response->transaction; });
  if (found == open_.end()) return;
  const auto open = std::move(*found);
  open_.erase(found);
  if (!response->ok) return refuse(open.requester, response->error);
  open.done(open.requester, *response);
}

std::optional<ToolRequests::Target> ToolRequests::target(const Requester& requester, const json& request,
                                                         const char* field) {
  const auto called = request_text(request, field);
  const auto address_on_island = request_text(request, "address");
  const auto known = devices_.find(called);
  const auto listed = address_on_island.empty() ? std::nullopt : devices_.find(address_on_island);
  if (known && listed && *known != *listed) {
    refuse(requester, fmt::format("{} is {} in Zigbee2MQTT, but {} on the island: name the device by its address",
                                  model::quoted(called), *known, *listed));
    return std::nullopt;
  }
  const auto address = known ? known : listed;
  if (!address) {
    refuse(requester, fmt::format("Zigbee2MQTT has no device {}", model::quoted(called)));
    return std::nullopt;
  }
  constexpr std::string_view kGroup = "group-";
  if (address->starts_with(kGroup)) return Target{*address, address->substr(kGroup.size()), true};
  return Target{*address, "0x" + *address, false};
}

void ToolRequests::permit(Requester requester, const json& request) {
  const auto wanted = request.value("seconds", json(60));
  if (!wanted.is_number_integer() || wanted < 0 || wanted > kMaxPermit)
    return refuse(requester,
                  fmt::format("seconds is {}, expected 0 to {}", model::dump(wanted).substr(0, 40), kMaxPermit));
  const auto seconds = wanted.get<std::int64_t>();
  if (seconds > 0 && !may_watch(requester)) return refuse(requester, kTooManyWatch);
  json payload{{"time", seconds}};
  if (!request_text(request, "via").empty()) {
    const auto via = target(requester, request, "via");
    if (!via) return;
    payload["device"] = via->id;
  }
  ask(std::move(requester), "permit_join", std::move(payload), kAnswerTime,
      [this, seconds](const Requester& to, const bridge::BridgeResponse&) { permitted(to, seconds); });
}

bool ToolRequests::may_watch(const Requester& requester) const {
  return watching_.size() < kMaxWatching || std::any_of(watching_.begin(), watching_.end(), [&](const Watching& one) {
           return one.requester.address == requester.address && one.requester.id == requester.id;
         });
}

void ToolRequests::permitted(const Requester& requester, std::int64_t seconds) {
  if (seconds > 0 && !may_watch(requester)) return refuse(requester, kTooManyWatch);
  const auto until = host_.scheduler().wall_now() + std::chrono::seconds(seconds);
  reply(requester, {{"ok", true}, {"until", base::to_seconds(until)}});
  if (seconds == 0) return close_watching({});
  watching_.remove_if([&](const Watching& one) {
    return one.requester.address == requester.address && one.requester.id == requester.id;
  });
  // Zigbee2MQTT publishes bridge/info before the response.
  auto& added = watching_.emplace_back(Watching{requester, joining_, {}});
  added.end = host_.scheduler().after(std::chrono::seconds(seconds), [this, &added] {
    send(added.requester.address, kEventTag, {{"id", added.requester.id}, {"event", "closed"}});
    watching_.remove_if([&](const Watching& one) { return &one == &added; });
  });
}

void ToolRequests::close_watching(std::string_view why) {
  for (const auto& watching : std::exchange(watching_, {})) {
    json closed{{"id", watching.requester.id}, {"event", "closed"}};
    if (!why.empty()) closed["why"] = why;
    send(watching.requester.address, kEventTag, closed);
  }
}

void ToolRequests::event(const bridge::BridgeEvent& event) {
  if (watching_.empty() || event.kind == bridge::BridgeEvent::Kind::kOther) return;
  json out{{"event", to_string(event.kind)}, {"address", event.address}, {"name", event.name}};
  if (!event.vendor.empty()) out["vendor"] = event.vendor;
  if (!event.model.empty()) out["model"] = event.model;
  if (event.kind == bridge::BridgeEvent::Kind::kFailed)
    out["why"] = "the device did not answer the interview: bring it nearer, wake it up and pair it again";
  if (event.kind == bridge::BridgeEvent::Kind::kInterviewed && !event.supported)
    out["why"] = "Zigbee2MQTT does not support this model";
  for (const auto& watching : watching_) {
    out["id"] = watching.requester.id;
    send(watching.requester.address, kEventTag, out);
  }
}

void ToolRequests::info(std::string_view payload, const bridge::BridgeDescription& info) {
  info_ = payload;
  joining_ = info.permit_join;
  texts_["bridge"] = model::dump(bridge_json(info));
  texts_["settings"] = model::dump(settings_json(info));
  std::list<Watching> closed;
  for (auto at = watching_.begin(); at != watching_.end();) {
    auto& watching = *at++;
    if (!info.permit_join && watching.open) closed.splice(closed.end(), watching_, std::prev(at));
    watching.open = info.permit_join;
  }
  for (const auto& one : closed)
    send(one.requester.address, kEventTag, {{"id", one.requester.id}, {"event", "closed"}});
}

json ToolRequests::described(const bridge::DeviceRecord& record, const std::string& why) const {
  const auto condition = devices_.condition(record.address);
  json out{{"address", record.address},
           {"name", record.name},
           {"role", record.is_group() ? "group" : word(record.role)},
           {"power", record.power_source},
           {"vendor", record.vendor},
           {"model", record.model},
           {"interview", word(record.interview)},
           {"supported", record.supported},
           {"points", condition.points}};
  if (condition.available) out["availability"] = *condition.available ? "online" : "offline";
  if (condition.last_seen != WallTime{}) out["last_seen"] = base::to_seconds(condition.last_seen);
  if (condition.link_quality) out["link_quality"] = *condition.link_quality;
  if (!why.empty()) out["why"] = why;
  return out;
}

/// A tool reads them all by repeated requests.
void ToolRequests::devices(const Requester& requester, const json& request) {
  const auto from = model::count_of(request, "from");
  auto list = json::array();
  std::size_t bytes = 0;
  std::uint64_t number = 0;
  bool more = false;
  devices_.each([&](const bridge::DeviceRecord& record, const std::string& why) {
    if (number++ < from || more) return;
    auto one = described(record, why);
    bytes += model::dump(one).size();
    more = bytes > kMaxReplyBytes;
    if (!more) list.push_back(std::move(one));
  });
  json answer{{"ok", true}, {"devices", std::move(list)}, {"more", more}, {"listed", devices_.lists_arrived()}};
  if (!devices_.lists_arrived()) answer["why"] = why_unlisted();
  reply(requester, std::move(answer));
}

std::string ToolRequests::why_unlisted() const {
  if (!down_.empty()) return down_;
  auto trouble = trouble_();
  return trouble.empty() ? "Zigbee2MQTT did not publish the list of devices yet; ask again in some seconds" : trouble;
}

void ToolRequests::rename(Requester requester, const json& request) {
  const auto device = target(requester, request, "device");
  if (!device) return;
  const auto to = request_text(request, "to");
  if (const auto why = bridge::new_name_problem(to); !why.empty()) return refuse(requester, why);
  ask(std::move(requester), device->group ? "group/rename" : "device/rename", {{"from", device->id}, {"to", to}},
      kAnswerTime, [this, to, address = device->address](const Requester& asker, const bridge::BridgeResponse&) {
        reply(asker, {{"ok", true}, {"address", address}, {"name", to}});
      });
}

void ToolRequests::remove(Requester requester, const json& request) {
  const auto device = target(requester, request, "device");
  if (!device) return;
  json payload{{"id", device->id}, {"force", model::flag_of(request, "force")}};
  if (!device->group) {
    payload["block"] = false;
    payload["keep_config"] = false;
  }
  ask(std::move(requester), device->group ? "group/remove" : "device/remove", std::move(payload), kAnswerTime,
      [this, address = device->address](const Requester& asker, const bridge::BridgeResponse&) {
        reply(asker, {{"ok", true}, {"address", address}});
      });
}

void ToolRequests::options(Requester requester, const json& request) {
  const auto device = target(requester, request, "device");
  if (!device) return;
  const auto set = request.find("set");
  if (set == request.end()) {
    const auto* record = device->group ? nullptr : devices_.inventory().find(device->address);
    auto all = device_options(device->id, record ? record->options.items() : std::vector<std::string>(), info_);
    all["ok"] = true;
    return reply(requester, std::move(all));
  }
  if (!set->is_object() || set->empty()) return refuse(requester, "set is no JSON object with options");
  ask(std::move(requester), device->group ? "group/options" : "device/options", {{"id", device->id}, {"options", *set}},
      kAnswerTime, [this](const Requester& asker, const bridge::BridgeResponse& response) {
        const auto data = model::object_of(response.data);
        json options = json::array();
        if (const auto now = data.find("to"); now != data.end() && now->is_object()) {
          for (const auto& [name, value] : now->items()) options.push_back({{"name", name}, {"value", value}});
        }
        reply(asker, {{"ok", true},
                      {"options", std::move(options)},
                      {"restart_required", model::flag_of(data, "restart_required")}});
      });
}

/// Asking for a map loads the radio for seconds: what is there is sent in parts.
void ToolRequests::map(Requester requester, const json& request) {
  const auto from = model::count_of(request, "from");
  if (from > 0 && map_) return send_map(requester, from);
  ask(std::move(requester), "networkmap", {{"type", "raw"}, {"routes", false}}, kMapTime,
      [this](const Requester& asker, const bridge::BridgeResponse& response) {
        auto read = bridge::read_network_map(response.data);
        if (!read) return refuse(asker, read.error().text);
        map_ = std::move(*read);
        map_end_ = host_.scheduler().after(kMapLife, [this] { map_.reset(); });
        send_map(asker, 0);
      });
}

/// Nodes and links, counted as one list.
void ToolRequests::send_map(const Requester& requester, std::size_t from) {
  auto nodes = json::array(), links = json::array();
  std::size_t bytes = 0, next = from;
  const auto all = map_->nodes.size() + map_->links.size();
  for (; next < all && bytes < kMaxReplyBytes; ++next) {
    auto& list = next < map_->nodes.size() ? nodes : links;
    if (next < map_->nodes.size()) {
      const auto& node = map_->nodes[next];
      list.push_back({{"address", node.address},
                      {"name", node.name},
                      {"role", node.role},
                      {"vendor", node.vendor},
                      {"model", node.model},
                      {"failed", node.failed}});
    } else {
      const auto& link = map_->links[next - map_->nodes.size()];
      list.push_back({{"source", link.source},
                      {"target", link.target},
                      {"quality", link.quality},
                      {"depth", link.depth},
                      {"relation", link.relation}});
    }
    bytes += model::dump(list.back()).size();
  }
  json answer{{"ok", true}, {"nodes", std::move(nodes)}, {"links", std::move(links)}, {"more", next < all}};
  if (next < all) answer["next"] = next;
  reply(requester, std::move(answer));
}

void ToolRequests::health_check(Requester requester) {
  ask(std::move(requester), "health_check", json::object(), kAnswerTime,
      [this](const Requester& asker, const bridge::BridgeResponse& response) {
        json answer{{"ok", true}, {"healthy", model::flag_of(model::object_of(response.data), "healthy")}};
        if (const auto bridge = texts_.find("bridge"); bridge != texts_.end())
          answer["bridge"] = model::object_of(bridge->second);
        if (const auto read = bridge::read_health(health_); read && !health_.empty())
          answer["health"] = health_json(*read);
        reply(asker, std::move(answer));
      });
}

void ToolRequests::refuse(const Requester& requester, std::string_view why) {
  reply(requester, {{"ok", false}, {"why", why}});
}

void ToolRequests::reply(const Requester& requester, json answer) {
  answer["id"] = requester.id;
  send(requester.address, kReplyTag, answer);
}

void ToolRequests::send(const Address& to, std::string_view tag, const json& content) {
  Message message;
  message.destination = to;
  const auto text = model::dump(content);
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(tag), Bytes(bytes.begin(), bytes.end())};
  host_.deliver(std::move(message));
}

}  // namespace rubicon::networks::zigbee
