#include "networks/zigbee/device_table.h"

#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

/// The devices of a house without a network around them.
class DevicesTest : public House {
 protected:
  bool repeats(const std::string& topic, const std::string& payload) const {
    return devices.repeats({"zigbee2mqtt/" + topic, payload});
  }

  ZigbeeOptions options;
  bridge::Topics topics{"zigbee2mqtt"};
  BrokerLine line{host, options.broker, {}};
  DeviceTable devices{host, types, options, topics, line, [] {}};
};

/// What is dropped where too many messages wait.
TEST_F(DevicesTest, LaterStatesRepeatAllButEventsAndAvailability) {
  devices.list(json{plug(), thermometer(), button()}.dump(), true);
  host.time.run_for(1s);
  EXPECT_TRUE(repeats("plug", R"({"power":7,"action":"single"})")) << "it has no such event";
  EXPECT_TRUE(repeats("button", R"({"linkquality":70})"));
  EXPECT_FALSE(repeats("button", R"({"action":"single"})"));
  EXPECT_FALSE(repeats("plug/availability", R"({"state":"online"})"));
  EXPECT_TRUE(repeats("stranger", R"({"action":"single"})"));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
