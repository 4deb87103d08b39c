#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/config_reader.h"
#include "networks/zigbee/tool_requests.h"
#include "networks/zigbee/zigbee_network.h"
#include "support/config_text.h"
#include "support/fake_host.h"
#include "support/memory/mqtt_broker.h"

namespace rubicon::networks::zigbee {

using namespace std::chrono_literals;
using nlohmann::json;

/// A ZigBee network on a broker in memory, where the test says what the bridge publishes.
class House : public ::testing::Test {
 protected:
  static constexpr const char* kPlug = "00124b0010000002";
  static constexpr const char* kThermometer = "00124b0010000003";
  static constexpr const char* kButton = "00124b0010000004";

  /// Makes the network, without open().
  void make(const std::string& options = R"({"broker": "localhost"})") {
    options_ = support::config_of(std::string_view(options));
    ConfigErrors errors;
    ConfigReader reader(options_, "networks.zigbee", errors);
    auto made = kType.make({"zigbee", IslandId{1}, reader, types, {}}, host);
    ASSERT_TRUE(made && errors.empty()) << errors.text();
    network = std::move(*made);
  }
  /// A network that runs beside a bridge with a plug, a thermometer and a button.
  void start() {
    make();
    bridge_starts();
    open();
  }
  void open() {
    ASSERT_TRUE(network->open());
    host.time.run_for(1s);
  }
  /// What the supervisor does after a lost line.
  void reopen() {
    host.time.run_for(100ms);
    ASSERT_TRUE(network->open());
    host.time.run_for(1s);
  }

  // -- the bridge
  static json numeric(const std::string& name, int access, const std::string& unit = {}) {
    json leaf{{"type", "numeric"}, {"name", name}, {"label", name}, {"property", name}, {"access", access}};
    if (!unit.empty()) leaf["unit"] = unit;
    return leaf;
  }
  static json record(const std::string& address, const std::string& name, json exposes, bool battery) {
    return {{"ieee_address", "0x" + address},
            {"friendly_name", name},
            {"type", battery ? "EndDevice" : "Router"},
            {"supported", true},
            {"disabled", false},
            {"interview_state", "SUCCESSFUL"},
            {"power_source", battery ? "Battery" : "Mains (single phase)"},
            {"definition",
             {{"model", "M1"},
              {"vendor", "Maker"},
              {"description", "A device"},
              {"exposes", std::move(exposes)},
              {"options", json::array()}}},
            {"endpoints", json::object()}};
  }
  static json plug(const std::string& name = "plug") {
    const json state{{"type", "binary"}, {"name", "state"},  {"label", "State"},   {"property", "state"},
                     {"access", 7},      {"value_on", "ON"}, {"value_off", "OFF"}, {"value_toggle", "TOGGLE"}};
    return record(kPlug, name, {{{"type", "switch"}, {"features", {state}}}, numeric("power", 5, "W")}, false);
  }
  static json thermometer(const std::string& name = "air") {
    return record(kThermometer, name, {numeric("temperature", 1, "°C"), numeric("humidity", 1, "%")}, true);
  }
  static json button(const std::string& name = "button") {
    return record(kButton, name,
                  {{{"type", "enum"},
                    {"name", "action"},
                    {"label", "Action"},
                    {"property", "action"},
                    {"access", 1},
                    {"category", "diagnostic"},
                    {"values", {"single", "double"}}}},
                  true);
  }
  json info(const std::string& version = "2.14.1", bool permit = false) const {
    return json{{"version", version},
                {"commit", "3c3d8c1a"},
                {"coordinator", {{"type", "EZSP v13"}, {"ieee_address", "0x00124b0010000001"}}},
                {"network", {{"channel", 11}}},
                {"permit_join", permit},
                {"restart_required", false},
                {"config",
                 {{"advanced",
                   {{"last_seen", "ISO_8601"}, {"output", "json"}, {"log_level", "warning"}, {"cache_state", true}}},
                  {"availability", {{"enabled", availability}}},
                  {"mqtt", {{"base_topic", "zigbee2mqtt"}}},
                  {"device_options", json::object()},
                  {"devices", json::object()}}}};
  }
  void say(const std::string& topic, const json& payload, bool retain = false) {
    broker.publish("zigbee2mqtt/" + topic, payload.is_string() ? payload.get<std::string>() : payload.dump(), retain);
    host.time.run_for(10ms);
  }
  void list(const json& devices) { say("bridge/devices", devices, true); }
  void online(bool yes = true) { say("bridge/state", {{"state", yes ? "online" : "offline"}}, true); }
  void bridge_starts(const json& devices = {plug(), thermometer(), button()}) {
    say("bridge/info", info(), true);
    list(devices);
    online();
  }
  /// A state message that the device caused now.
  void report(const std::string& name, json state) {
    state["last_seen"] = now_text();
    say(name, state);
  }
  std::string now_text() const {
    const auto at = std::chrono::time_point_cast<std::chrono::milliseconds>(host.time.wall_now());
    const auto days = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(days);
    const std::chrono::hh_mm_ss clock(at - days);
    char text[40];
    std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", int(date.year()), unsigned(date.month()),
                  unsigned(date.day()), int(clock.hours().count()), int(clock.minutes().count()),
                  int(clock.seconds().count()), int(clock.subseconds().count()));
    return text;
  }

  // -- what the network delivered
  std::vector<std::string> joins() const {
    std::vector<std::string> out;
    for (const auto& [device, join] : host.all<model::Join>()) out.push_back(device + " " + join.name);
    return out;
  }
  model::State state() const {
    const auto all = host.all<model::State>();
    return all.empty() ? model::State{} : all.back().second;
  }
  std::uint64_t counter(const std::string& name) {
    host.time.run_for(1s);
    return state().counters.at(name);
  }
  /// The values that a device reported at points of this type, in the words of the type.
  std::vector<std::string> values(const std::string& device, const std::string& type, bool heard = true) const {
    std::vector<std::string> out;
    for (const auto& [from, updates] : host.all<model::Updates>()) {
      for (const auto& reading : updates.readings) {
        if (from != device || reading.point.type != types.find(type)->id || updates.heard != heard) continue;
        out.push_back(model::to_text(reading.value));
      }
    }
    return out;
  }
  std::size_t readings() const {
    std::size_t count = 0;
    for (const auto& [from, updates] : host.all<model::Updates>()) count += updates.readings.size();
    return count;
  }
  std::optional<model::Acknowledge> answer(std::uint64_t request) const {
    std::optional<model::Acknowledge> found;
    for (const auto& [from, one] : host.all<model::Acknowledge>()) {
      if (one.request == request) {
        EXPECT_FALSE(found) << "answered twice";
        found = one;
      }
    }
    return found;
  }

  // -- what the island asks
  Result<void> send(const std::string& device, model::Body body) {
    Message message;
    message.source = {IslandId{1}, {}, {}};
    message.destination = {IslandId{1}, "zigbee", device};
    message.body = std::move(body);
    return network->send(message);
  }
  model::PointId actuator(const std::string& type) const { return {Kind::kActuator, types.find(type)->id, "1"}; }
  Result<void> command(std::uint64_t request, const std::string& device, const std::string& type, Value value) {
    return send(device, model::Actuate{request, actuator(type), std::move(value), 20s});
  }
  std::vector<std::string> sets(const std::string& name) const {
    return broker.published("zigbee2mqtt/" + name + "/set");
  }
  std::vector<std::string> gets(const std::string& name) const {
    return broker.published("zigbee2mqtt/" + name + "/get");
  }

  // -- tools
  /// Without a tag in a message of the type that the request needs.
  void ask(const json& request, std::string_view tag = {}) {
    Message message;
    message.source = {IslandId{1}, {}, "tool"};
    message.destination = {IslandId{1}, "zigbee", {}};
    const auto text = request.dump();
    const auto bytes = base::as_bytes(text);
    message.body = model::Opaque{std::string(tag.empty() ? tag_of(request) : tag), Bytes(bytes.begin(), bytes.end())};
    EXPECT_TRUE(network->send(message));
    host.time.run_for(10ms);
  }
  /// Messages to tools with this tag, in order.
  std::vector<json> to_tools(const std::string& tag) const {
    std::vector<json> out;
    for (const auto& message : host.delivered) {
      const auto* opaque = std::get_if<model::Opaque>(&message.body);
      if (opaque != nullptr && opaque->type == tag)
        out.push_back(json::parse(opaque->bytes.begin(), opaque->bytes.end()));
    }
    return out;
  }
  /// The newest request that the network published to `bridge/request/<what>`.
  json requested(const std::string& what) const {
    const auto all = broker.published("zigbee2mqtt/bridge/request/" + what);
    return all.empty() ? json() : json::parse(all.back());
  }
  void respond(const std::string& what, const json& data) {
    say("bridge/response/" + what,
        {{"data", data}, {"status", "ok"}, {"transaction", requested(what).value("transaction", "")}});
  }
  void refuse(const std::string& what, const std::string& error) {
    say("bridge/response/" + what, {{"data", json::object()},
                                    {"status", "error"},
                                    {"error", error},
                                    {"transaction", requested(what).value("transaction", "")}});
  }

  TypeCatalogue types;
  bool availability = false;
  support::FakeHost host;
  transport::MqttBroker broker{host.net, {"127.0.0.1", 1883}};
  ConfigNode options_;
  std::unique_ptr<network::Network> network;
};

}  // namespace rubicon::networks::zigbee
