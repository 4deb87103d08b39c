#include "apps/simulators/zigbee/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"

namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A world on a broker in memory.
class BridgeOnBroker : public ::testing::Test {
 protected:
  BridgeOnBroker() {
    memory.join(net);
    EXPECT_TRUE(world.add(find_model("plug").value(), "hall/plug"));
  }
  void open() {
    ASSERT_TRUE(line.open());
    time.run_for(100ms);
  }
  static transport::MqttOptions options() {
    transport::MqttOptions made;
    made.host = "localhost";
    made.client_id = "bridge";
    return made;
  }

  VirtualScheduler time;
  support::CollectingLog words;
  transport::MemoryNet net{time};
  transport::MemoryTransports memory;
  transport::MqttBroker broker{net, {"127.0.0.1", 1883}};
  World world{{}, time, Log(words, "world")};
  BrokerLine line{world, options(), time, memory, Log(words, "line")};
};

TEST_F(BridgeOnBroker, TakesCommandsForNamesWithSlashes) {
  open();
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"online"})");
  broker.publish("zigbee2mqtt/hall/plug/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_THAT(broker.published("zigbee2mqtt/hall/plug").back(), HasSubstr(R"("state":"OFF")"));
}

TEST_F(BridgeOnBroker, ADeviceWhoseNameLooksLikeACommandCommandsNoOther) {
  EXPECT_TRUE(world.add(find_model("plug").value(), "hall/plug/set"));
  open();
  world.radio().change(*world.registry().find("hall/plug/set"), "state", "OFF");
  time.run_for(1s);
  EXPECT_EQ(world.counters().sets, 0U);
  broker.publish("zigbee2mqtt/hall/plug/set/set", R"({"state":"ON"})");
  time.run_for(1s);
  EXPECT_THAT(broker.published("zigbee2mqtt/hall/plug/set").back(), HasSubstr(R"("state":"ON")"));
}

TEST_F(BridgeOnBroker, FollowsARenameWithItsSubscriptions) {
  open();
  broker.publish("zigbee2mqtt/bridge/request/device/rename", R"({"from":"hall/plug","to":"plug"})");
  time.run_for(1s);
  EXPECT_THAT(broker.subscriptions(),
              ElementsAre("zigbee2mqtt/bridge/request/#", "zigbee2mqtt/plug/get/#", "zigbee2mqtt/plug/set/#"));
  EXPECT_EQ(broker.retained("zigbee2mqtt/hall/plug/availability"), std::nullopt);
}

TEST_F(BridgeOnBroker, LeavesItsWillWhenTheConnectionBreaks) {
  open();
  broker.cut("bridge");
  time.run_for(10ms);
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"offline"})");
  time.run_for(2s);
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"online"})");
}

TEST_F(BridgeOnBroker, ComesBackToABrokerWithoutMemoryWithItsStateOnly) {
  open();
  broker.stop(false);
  time.run_for(10s);
  broker.start();
  time.run_for(3s);
  EXPECT_TRUE(line.connected());
  EXPECT_THAT(broker.retained(), ElementsAre(std::pair("zigbee2mqtt/bridge/state", R"({"state":"online"})")));
  EXPECT_EQ(std::ranges::count_if(words.lines, [](auto& one) { return one.find("refused") != one.npos; }), 1)
      << "an error that lasts is reported once";
}

TEST_F(BridgeOnBroker, WaitsForABrokerThatIsNotThereYet) {
  broker.stop(false);
  open();
  time.run_for(5s);
  EXPECT_FALSE(line.connected());
  broker.start();
  time.run_for(2s);
  EXPECT_TRUE(broker.retained("zigbee2mqtt/bridge/devices").has_value())
      << "the world starts with the first connection";
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
