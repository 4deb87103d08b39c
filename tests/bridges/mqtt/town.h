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
#include "bridges/town_island.h"
#include "support/collecting_log.h"
#include "support/config_text.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "support/rights.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bridges::mqtt {

using namespace std::chrono_literals;
using nlohmann::json;

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
  std::shared_ptr<rights::RightsJudge> judge = std::make_shared<rights::RightsJudge>(rights::Rights(
      {support::rule("everybody", {support::Right::kRead, support::Right::kDemand, support::Right::kSet})}));
  bool alone = false;
  std::unique_ptr<Bridge> made;

 private:
  ConfigNode options_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
};

}  // namespace rubicon::bridges::mqtt
