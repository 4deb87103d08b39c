#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "bridges/bridge.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "rubicon/summary.hpp"
#include "support/collecting_log.h"
#include "support/config_text.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "support/rights.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bridges::mqtt {

using namespace std::chrono_literals;
using nlohmann::json;

/// A point as an island describes it.
struct Described {
  std::string kind, id;  ///< `sensor`, `temperature-1`
  std::string value{};
  std::string quality = "good";
  std::vector<std::string> words{};  ///< of the device; empty = those of the type
  std::string access{};              ///< empty = by kind
};

/// An island as others see it: its tuples are what the test says, and commands to them are kept.
class TownIsland {
 public:
  TownIsland(tuples::MemoryEcology& ecology, VirtualScheduler& time, OwnerId id, const std::string& name)
      : time_(time), link_(ecology.join(id).value()), space(id, time, *link_) {
    EXPECT_TRUE(space.describe(model::to_json(Summary{name, "hall", "rubicon-proxy 9", "proxy", time.wall_now()})));
    policy_ = space.add_policy(Pattern::parse("proxy.**").value(), [this](const tuples::RemoteSet& set) {
      sets.push_back(set);
      if (!refuses.empty()) return tuples::SetDecision::refused({ErrorCode::kRefused, refuses});
      return tuples::SetDecision::consumed();
    });
  }
  void network(const std::string& id, const std::string& line = "up") {
    put("proxy." + id + ".status", json{{"line", line}, {"reason", ""}, {"since", 1}}.dump());
  }
  /// With its network; `network.device`.
  void device(const std::string& at, const std::string& name, const std::vector<Described>& points,
              const std::string& area = {}, const std::string& status = "reachable") {
    model::DeviceDescription about;
    about.name = name;
    about.area = area;
    about.model = "M1";
    for (const auto& point : points) {
      auto& ids = point.kind == "sensor"     ? about.sensors
                  : point.kind == "actuator" ? about.actuators
                                             : about.properties;
      ids.push_back(point.id);
    }
    put("proxy." + at + ".description", model::device_description_to_json(about));
    reach(at, status);
    for (const auto& point : points) this->point(at, point);
  }
  void reach(const std::string& at, const std::string& status) {
    put("proxy." + at + ".status", json{{"status", status}, {"reason", ""}, {"since", 1}}.dump());
  }
  void point(const std::string& at, const Described& point) {
    const auto key = fmt::format("proxy.{}.{}.{}", at, point.kind, point.id);
    const auto* type = types_.find(point.id.substr(0, point.id.find('-')));
    ASSERT_NE(type, nullptr) << point.id;
    model::PointDescription about;
    about.type = type->name;
    about.unit = type->unit;
    about.data_type = to_string(type->data);
    if (std::isfinite(type->minimum)) about.minimum = type->minimum;
    if (std::isfinite(type->maximum)) about.maximum = type->maximum;
    about.words = model::words_in(type->words);
    if (!point.words.empty()) about.words.clear();
    for (const auto& word : point.words) about.words.push_back({static_cast<std::uint32_t>(about.words.size()), word});
    about.access = !point.access.empty() ? point.access : point.kind == "sensor" ? "read" : "read-write";
    about.report = type->report == model::Report::kEvent ? "event" : "state";
    put(key + ".description", model::point_description_to_json(about));
    say(at, point);
  }
  void say(const std::string& at, const Described& point) {
    const auto key = fmt::format("proxy.{}.{}.{}", at, point.kind, point.id);
    std::string status;
    model::write_point_status({point.quality, "", {}, time_.wall_now(), {}, command, ended}, status);
    put(key + ".status", status);
    put(key + ".value", point.value);
  }
  void put(const std::string& key, const std::string& value) { ASSERT_TRUE(space.set(key, value)) << key; }
  void remove_device(const std::string& at) { space.erase(Pattern::parse("proxy." + at + ".**").value()); }
  /// The state of the last command of a point.
  void report(const std::string& at, const Described& point, const std::string& state, const std::string& reason = {}) {
    model::CommandStatus told;
    told.state = state;
    told.reason = reason;
    told.commander = {sets.back().from, "bridge", sets.back().request};
    command = model::command_status_to_json(told);
    say(at, point);
    command.clear();
  }

  std::vector<tuples::RemoteSet> sets;
  std::string refuses;  ///< not empty: each set, with this reason

 private:
  VirtualScheduler& time_;
  std::unique_ptr<tuples::Link> link_;

 public:
  TupleSpace space;
  std::string command, ended;

 private:
  Handle policy_;
  TypeCatalogue types_;
};

/// A bridge on island 6541 and a broker, in virtual time.
class Town : public ::testing::Test {
 protected:
  Town() {
    files.join(net);
    judge->record_by(audit);
  }

  /// `options` beside broker and type.
  void bridge(const std::string& options = "{}") {
    auto all = json::parse(options);
    if (!all.contains("broker")) all["broker"] = "localhost";
    options_ = support::config_of(nlohmann::ordered_json(all));
    base::ConfigErrors errors;
    ConfigReader reader(options_, "bridges.ha", errors);
    link_ = ecology.join(OwnerId(70000)).value();
    space_ = std::make_unique<TupleSpace>(OwnerId(70000), time, *link_);
    const BridgeHost host{"ha",    time,       *space_, files, log, alone ? std::nullopt : std::optional(OwnerId(6541)),
                          "proxy", judge.get()};
    made = find_bridge_type("mqtt")->make(reader, "", &host);
    ASSERT_TRUE(made) << errors.text();
    made->start();
    time.run_for(1s);
  }
  void end_bridge() {
    made.reset();
    space_.reset();
    link_.reset();
    time.run_for(100ms);
  }
  std::string at(const std::string& topic) const { return broker.retained(topic).value_or("(nothing)"); }
  json announced(const std::string& device) const {
    return json::parse(at("homeassistant/device/rubicon_6541_" + device + "/config"), nullptr, false);
  }
  void send(const std::string& topic, const std::string& payload, bool retain = false) {
    broker.publish(topic, payload, retain);
    time.run_for(100ms);
  }
  std::string outcome(const std::string& topic) const {
    const auto all = broker.published(topic + "/outcome");
    return all.empty() ? "(none)" : json::parse(all.back()).at("state").get<std::string>();
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, {"127.0.0.1", 1883}};
  transport::MemoryTransports files;
  support::CollectingLog log;
  tuples::MemoryEcology ecology{time};
  TownIsland island{ecology, time, OwnerId(6541), "home"};
  std::shared_ptr<support::CollectingAudit> audit = std::make_shared<support::CollectingAudit>();
  std::shared_ptr<trust::rights::RightsJudge> judge =
      std::make_shared<trust::rights::RightsJudge>(trust::rights::Rights(
          {support::rule("everybody", {support::Right::kRead, support::Right::kDemand, support::Right::kSet})}));
  bool alone = false;
  std::unique_ptr<Bridge> made;

 private:
  ConfigNode options_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
};

}  // namespace rubicon::bridges::mqtt
