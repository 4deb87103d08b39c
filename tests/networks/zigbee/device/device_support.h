#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/zigbee/device.h"

namespace rubicon::networks::zigbee {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

/// A network that keeps what a device publishes and delivers.
class FakeDeviceHost final : public DeviceHost {
 public:
  struct Publication {
    std::string name, verb, payload;
    SteadyTime at{};
  };

  Result<void> publish(const std::string& name, std::string_view verb, std::string payload) override {
    if (refuse) return fail(ErrorCode::kBusy, "the queue is full");
    published.push_back({name, std::string(verb), std::move(payload), time.now()});
    if (on_publish) on_publish(published.back());
    if (verb == "set" && taken) time.post([this] { taken(); });
    return {};
  }
  void deliver(const std::string&, model::Body body) override {
    delivered.push_back(std::move(body));
    delivered_at.push_back(time.now());
  }
  Scheduler& scheduler() override { return time; }
  bool take_poll(const std::string&) override { return polls_left > 0 && polls_left-- > 0; }

  template <class Body>
  std::vector<Body> all() const {
    std::vector<Body> found;
    for (const auto& body : delivered) {
      if (const auto* one = std::get_if<Body>(&body)) found.push_back(*one);
    }
    return found;
  }
  std::vector<std::string> payloads(std::string_view verb) const {
    std::vector<std::string> found;
    for (const auto& one : published) {
      if (one.verb == verb) found.push_back(one.payload);
    }
    return found;
  }

  VirtualScheduler time;
  std::vector<Publication> published;
  std::vector<model::Body> delivered;
  std::vector<SteadyTime> delivered_at;
  std::function<void(const Publication&)> on_publish;
  std::function<void()> taken;  ///< the broker took a set message
  bool refuse = false;
  int polls_left = 1'000'000;
};

namespace definitions {
inline constexpr std::string_view kLamp = R"([{"type":"light","features":[
  {"type":"binary","name":"state","property":"state","access":7,"value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"},
  {"type":"numeric","name":"brightness","property":"brightness","access":7,"value_min":0,"value_max":254},
  {"type":"composite","name":"color_xy","property":"color","access":7,"features":[
    {"type":"numeric","name":"x","property":"x","access":7},{"type":"numeric","name":"y","property":"y","access":7}]},
  {"type":"composite","name":"color_hs","property":"color","access":7,"features":[
    {"type":"numeric","name":"hue","property":"hue","access":7},
    {"type":"numeric","name":"saturation","property":"saturation","access":7}]}]},
  {"type":"enum","name":"power_on_behavior","property":"power_on_behavior","access":7,"category":"config",
   "values":["off","on","previous"]},
  {"type":"enum","name":"identify","property":"identify","access":2,"category":"config","values":["identify"]}])";
inline constexpr std::string_view kPlug = R"([{"type":"switch","features":[
  {"type":"binary","name":"state","property":"state","access":7,"value_on":"ON","value_off":"OFF"}]},
  {"type":"numeric","name":"power","property":"power","access":5,"unit":"W"},
  {"type":"numeric","name":"voltage","property":"voltage","access":5,"unit":"V"}])";
inline constexpr std::string_view kWeather = R"([
  {"type":"numeric","name":"temperature","property":"temperature","access":1,"unit":"°C"},
  {"type":"numeric","name":"humidity","property":"humidity","access":1,"unit":"%"},
  {"type":"binary","name":"occupancy","property":"occupancy","access":1,"value_on":true,"value_off":false},
  {"type":"binary","name":"contact","property":"contact","access":1,"value_on":false,"value_off":true}])";
inline constexpr std::string_view kButton = R"([
  {"type":"enum","name":"action","property":"action","access":1,"category":"diagnostic","values":["single","double"]},
  {"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","unit":"%"}])";
/// A radiator valve on a battery: it can be set and asked, but it sleeps.
inline constexpr std::string_view kValve = R"([{"type":"climate","features":[
  {"type":"numeric","name":"occupied_heating_setpoint","property":"occupied_heating_setpoint","access":7,"unit":"°C",
   "value_min":7,"value_max":28,"value_step":0.5},
  {"type":"numeric","name":"local_temperature","property":"local_temperature","access":5,"unit":"°C"}]}])";
/// It can be set and not asked.
inline constexpr std::string_view kFan = R"([{"type":"switch","features":[
  {"type":"binary","name":"state","property":"state","access":3,"value_on":"ON","value_off":"OFF"}]},
  {"type":"numeric","name":"power","property":"power","access":1,"unit":"W"}])";
}  // namespace definitions

/// A device with this definition; `battery`: it sleeps.
inline bridge::DeviceRecord record_of(std::string_view definition, bool battery = false) {
  bridge::DeviceRecord record;
  record.address = "00124b0010000000";
  record.name = "kitchen/one";
  record.role = battery ? bridge::Role::kEndDevice : bridge::Role::kRouter;
  record.interview = bridge::Interview::kSuccessful;
  record.supported = true;
  record.vendor = "Maker";
  record.model = "M1";
  record.power_source = battery ? "Battery" : "Mains (single phase)";
  auto leaves = exposes::read_exposes(definition, record.skipped);
  EXPECT_TRUE(leaves) << leaves.error().text;
  record.leaves = leaves ? std::move(*leaves) : std::vector<exposes::Leaf>();
  return record;
}

/// `2026-01-01T00:00:05.250Z`.
inline std::string iso(WallTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(std::chrono::floor<milliseconds>(time - day));
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), clock.hours().count(),
                     clock.minutes().count(), clock.seconds().count(), clock.subseconds().count());
}

/// A device in virtual time whose line is up, and what it published since the last look.
class DeviceTest : public testing::Test {
 protected:
  using Values = std::vector<std::pair<std::string, std::string>>;  ///< type name, text

  /// Starts a device; the questions that it asks at once are over and forgotten.
  void start(bridge::DeviceRecord record, bool with_line = true) {
    device = std::make_unique<Device>(host, models, std::move(record));
    host.taken = [this] { device->taken(); };
    if (!with_line) return;
    device->line_up();
    host.time.run_for(seconds(20));
    forget();
  }
  void forget() {
    host.published.clear();
    host.delivered.clear();
    host.delivered_at.clear();
  }
  WallTime now() const { return host.time.wall_now(); }
  void run(Duration span) { host.time.run_for(span); }

  /// A message without last_seen; `members` without braces.
  void say_plain(const std::string& members) {
    const auto done = device->state("{" + members + "}", false);
    EXPECT_TRUE(done) << done.error().text;
  }
  void say(const std::string& members, WallTime seen) {
    say_plain(members + (members.empty() ? "" : ",") + "\"last_seen\":\"" + iso(seen) + "\"");
  }
  /// The device sends a report of its own: last_seen is now.
  void report(const std::string& members) {
    host.time.run_for(milliseconds(20));
    seen_ = now();
    say(members, seen_);
  }
  /// Zigbee2MQTT publishes by itself: last_seen stays.
  void echo(const std::string& members) { say(members, seen_); }

  PointId point(std::string_view property, std::size_t which = 0) const {
    for (const auto& one : device->points()) {
      if (one.property == property && which-- == 0) return one.capability.point;
    }
    ADD_FAILURE() << "no point has the property " << property;
    return {};
  }
  Result<void> command(std::string_view property, Value value, milliseconds life = milliseconds(0)) {
    const auto id = point(property);
    Message message;
    if (id.kind == Kind::kProperty)
      message.body = model::SetProperty{++request, id, std::move(value)};
    else
      message.body = model::Actuate{++request, id, std::move(value), life};
    return device->send(message);
  }
  /// Sends a command and has it published.
  void commanded(std::string_view property, Value value, milliseconds life = milliseconds(0)) {
    const auto done = command(property, std::move(value), life);
    ASSERT_TRUE(done) << done.error().text;
    host.time.run_ready();
  }
  void sample(const std::vector<std::string>& properties, milliseconds period) {
    model::Sample body{++request, {}, period};
    for (const auto& one : properties) body.points.push_back(point(one));
    Message message;
    message.body = std::move(body);
    EXPECT_TRUE(device->send(message));
    host.time.run_ready();
  }

  std::string name_of(const PointId& id) const {
    for (const auto& one : device->points()) {
      if (one.capability.point == id) return one.property;
    }
    return "?";
  }
  /// The readings so far, by property; `heard`: reported, else repeated from memory.
  Values readings(bool heard = true) const {
    Values found;
    for (const auto& updates : host.all<model::Updates>()) {
      if (updates.heard != heard) continue;
      for (const auto& one : updates.readings) {
        if (name_of(one.point) != "linkquality") found.emplace_back(name_of(one.point), to_text(one.value));
      }
    }
    return found;
  }
  std::vector<model::Reading> raw_readings() const {
    std::vector<model::Reading> found;
    for (const auto& updates : host.all<model::Updates>())
      found.insert(found.end(), updates.readings.begin(), updates.readings.end());
    return found;
  }
  /// `7 sent`, ...
  std::vector<std::string> answers() const {
    std::vector<std::string> found;
    for (const auto& one : host.all<model::Acknowledge>())
      found.push_back(fmt::format("{} {}", one.request, to_string(one.outcome)));
    return found;
  }
  std::string text_of_answer(std::uint64_t number) const {
    for (const auto& one : host.all<model::Acknowledge>()) {
      if (one.request == number) return one.text;
    }
    return "not answered";
  }
  std::vector<std::string> sets() const { return host.payloads("set"); }
  std::vector<std::string> gets() const { return host.payloads("get"); }

  TypeCatalogue types;
  exposes::PointsOfModels models{types};
  FakeDeviceHost host;
  std::unique_ptr<Device> device;
  std::uint64_t request = 0;

 private:
  WallTime seen_{};
};

}  // namespace rubicon::networks::zigbee
