#include "model/point_keys.h"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

TEST(PointKeys, AreBuiltFromTheirParts) {
  const IslandKey island{"proxy"};
  EXPECT_EQ(island.networks(), "proxy.networks");
  EXPECT_EQ(island.inbox(), "proxy.inbox");
  EXPECT_EQ(island.inbox("wsn-1.7"), "proxy.inbox.wsn-1.7");
  EXPECT_EQ(island.property("clock"), "proxy.property.clock.value");
  const auto network = island.network("wsn-1");
  EXPECT_EQ(network.status(), "proxy.wsn-1.status");
  EXPECT_EQ(network.property("line"), "proxy.wsn-1.property.line.value");
  const auto device = network.device("7");
  EXPECT_EQ(device.description(), "proxy.wsn-1.7.description");
  EXPECT_EQ(device.point(Kind::kSensor, "light-1").value(), "proxy.wsn-1.7.sensor.light-1.value");
  EXPECT_EQ(device.point("actuator", "*").command(), "proxy.wsn-1.7.actuator.*.command");
  EXPECT_EQ(any_point().status(), "*.*.*.*.*.status");
}

TEST(PointKeys, AreTakenApart) {
  EXPECT_EQ(parent_key("proxy.wsn-1.7.status"), "proxy.wsn-1.7");
  EXPECT_EQ(parent_key("GATEWAY"), "");
  EXPECT_EQ(last_part("proxy.wsn-1.7.status"), "status");
  EXPECT_EQ(last_part("GATEWAY"), "GATEWAY");
  EXPECT_EQ(network_of("proxy.wsn-1.7.sensor.light-1.value")->status(), "proxy.wsn-1.status");
  EXPECT_FALSE(network_of("GATEWAY"));
  EXPECT_EQ(point_of("proxy.wsn-1.7.sensor.light-1.status")->text, "proxy.wsn-1.7.sensor.light-1");
  EXPECT_FALSE(point_of("proxy.wsn-1.7.sensor.light-1.words")) << "no tuple of a point";
  EXPECT_FALSE(point_of("proxy.wsn-1.7.table.light-1.value")) << "no kind";
  EXPECT_FALSE(point_of("proxy.wsn-1.7.status"));
}

}  // namespace
}  // namespace rubicon::model
