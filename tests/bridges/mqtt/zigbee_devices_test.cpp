#include <fstream>
#include <sstream>

#include "bridges/bridge.h"
#include "bridges/mqtt/receiver_rules.h"
#include "scenarios/zigbee.h"
#include "support/config_text.h"

namespace rubicon::bridges::mqtt {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;

constexpr const char* kHere = "10.0.0.8";
constexpr const char* kModels[] = {"lamp", "plug",   "thermometer", "motion", "contact", "cover",
                                   "lock", "switch", "trv",         "remote", "relay",   "weather"};

/// `sensor temperature °C diagnostic`: what it is, its class, its unit and its category; `-` = none.
std::string core_of(const nlohmann::json& entity) {
  const auto or_none = [&](const char* key) { return entity.value(key, "-"); };
  return entity.value("p", "") + " " + or_none("dev_cla") + " " + or_none("unit_of_meas") + " " + or_none("ent_cat");
}

/// The simulated devices of ZigBee beside a bridge to another broker.
class ZigbeeDevices : public scenarios::Zigbee {
 protected:
  ZigbeeDevices() { here_.join(net, "10.0.0.3"); }
  ~ZigbeeDevices() override { bridge_.reset(); }

  void begin() {
    world = std::make_unique<zigbee_simulator::World>(zigbee_simulator::WorldOptions{}, scheduler, Log(log, "zigbee"));
    transport::MqttOptions where;
    where.host = kBrokerHost;
    bridge =
        std::make_unique<zigbee_simulator::BrokerLine>(*world, where, scheduler, bridge_transports, Log(log, "zigbee"));
    for (const auto* model : kModels) ASSERT_TRUE(world->add(zigbee_simulator::find_model(model).value(), model));
    ASSERT_TRUE(bridge->open());
    scheduler.run_for(2s);
    start();
    config_ = support::config_of(
        nlohmann::ordered_json{{"broker", kHere}, {"discovery", "homeassistant"}, {"commands", {"**"}}});
    base::ConfigErrors errors;
    ConfigReader reader(config_, "bridges.ha", errors);
    const BridgeHost host{"ha", scheduler, component(kRobot), here_, log, OwnerId(1), "proxy"};
    bridge_ = find_bridge_type("mqtt")->make(reader, "", &host);
    bridge_->start();
    scheduler.run_for(10s);
  }
  /// By model and id.
  std::map<std::string, std::string> announced() {
    std::map<std::string, std::string> all;
    for (const auto& [topic, payload] : other_.retained()) {
      const auto message = nlohmann::json::parse(payload, nullptr, false);
      if (!topic.ends_with("/config") || !message["dev"].contains("via_device")) continue;
      EXPECT_THAT(faults_of(message), IsEmpty()) << topic;
      for (const auto& [id, entity] : message["cmps"].items())
        if (id != "online") all[message["dev"]["name"].get<std::string>() + " " + id] = core_of(entity);
    }
    return all;
  }

 private:
  transport::MqttBroker other_{net, {kHere, 1883}};
  transport::MemoryTransports here_;
  ConfigNode config_;
  std::unique_ptr<Bridge> bridge_;
};

/// What Zigbee2MQTT announces for the same devices, row by row: the same, or why not.
TEST_F(ZigbeeDevices, AreAnnouncedAsZigbee2MqttDoesOrForAReason) {
  begin();
  auto ours = announced();
  std::ifstream file(std::string(RUBICON_SOURCE_DIR) + "/tests/cases/zigbee/home_assistant.tsv");
  ASSERT_TRUE(file);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::vector<std::string> columns;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, '\t');) columns.push_back(cell);
    ASSERT_EQ(columns.size(), 5U) << line;
    const auto &theirs = columns[2], &expected = columns[3], &why = columns[4];
    const auto found = ours.extract(columns[0] + " " + columns[1]);
    EXPECT_EQ(found.empty() ? "none" : found.mapped(), expected) << line;
    EXPECT_EQ(theirs == expected, why == "same") << line;
  }
  for (const auto& [id, entity] : ours) ADD_FAILURE() << "in no row: " << id << "\t" << entity;
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
