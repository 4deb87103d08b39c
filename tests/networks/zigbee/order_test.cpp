#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using model::LineState;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// No device becomes reachable while the line is down: the order of what the island receives.
class OrderOfArrivals : public House {
 protected:
  /// What devices and the line reported, in words.
  std::vector<std::string> order() const {
    std::vector<std::string> out;
    for (const auto& message : host.delivered) {
      const auto* updates = std::get_if<model::Updates>(&message.body);
      if (updates != nullptr) out.emplace_back(updates->heard ? "reading" : "stored");
      if (message.kind() == MessageKind::kKeepAlive) out.emplace_back("alive");
      if (message.kind() == MessageKind::kUnreachable) out.emplace_back("unreachable");
      const auto* line = std::get_if<model::State>(&message.body);
      const auto word = line == nullptr ? "" : line->line == LineState::kUp ? "up" : "down";
      if (line != nullptr && (out.empty() || out.back() != word)) out.emplace_back(word);
    }
    return out;
  }
  std::string state_text(double temperature) const {
    return json{{"temperature", temperature}, {"last_seen", now_text()}}.dump();
  }
};

TEST_F(OrderOfArrivals, AStateBeforeBridgeOfflineIsTakenBeforeTheLineIsDown) {
  availability = true;
  start();
  host.delivered.clear();
  broker.publish("zigbee2mqtt/air", state_text(21.5));
  broker.publish("zigbee2mqtt/air/availability", R"({"state":"online"})", true);
  broker.publish("zigbee2mqtt/bridge/state", R"({"state":"offline"})", true);
  host.time.run_for(10ms);
  EXPECT_THAT(order(), ElementsAre("reading", "alive", "down"));
}

TEST_F(OrderOfArrivals, RetainedAvailabilityCountsWhenTheBridgeIsBack) {
  availability = true;
  make();
  say("bridge/info", info(), true);
  list({plug(), thermometer(), button()});
  online(false);
  say("plug/availability", {{"state", "online"}}, true);
  say("air/availability", {{"state", "offline"}}, true);
  open();
  EXPECT_THAT(host.all<model::KeepAlive>(), IsEmpty());
  EXPECT_THAT(host.all<model::Unreachable>(), IsEmpty());
  host.delivered.clear();
  online();
  ASSERT_THAT(host.all<model::KeepAlive>(), SizeIs(1));
  EXPECT_EQ(host.all<model::KeepAlive>()[0].first, kPlug);
  ASSERT_THAT(host.all<model::Unreachable>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Unreachable>()[0].first, kThermometer);
  online(false);
  online();
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(1)) << "it counts once";
}

TEST_F(OrderOfArrivals, AStateWithoutABridgeIsAStoredOne) {
  start();
  online(false);
  host.delivered.clear();
  broker.publish("zigbee2mqtt/air", state_text(17));
  host.time.run_for(10ms);
  EXPECT_THAT(order(), ElementsAre("stored"));
}

/// 20 devices, 10 polls a second: each gets its turn.
TEST_F(OrderOfArrivals, MoreDevicesThanPollsTakeTurns) {
  make();
  auto all = json::array();
  for (int i = 0; i < 20; ++i) {
    auto one = plug(fmt::format("plug {}", i));
    one["ieee_address"] = fmt::format("0x00124b00200000{:02x}", i);
    all.push_back(std::move(one));
  }
  bridge_starts(all);
  open();
  host.time.run_for(5s);
  model::PointId power{Kind::kSensor, types.find("power")->id, {}};
  for (const auto& [from, join] : host.all<model::Join>()) {
    for (const auto& capability : join.capabilities) {
      if (capability.point.type == power.type) power = capability.point;
    }
  }
  for (int i = 0; i < 20; ++i)
    ASSERT_TRUE(send(fmt::format("00124b00200000{:02x}", i), model::Sample{std::uint64_t(i + 1), {power}, 1s}));
  host.time.run_for(5s);
  std::size_t total = 0;
  for (int second = 0; second < 3; ++second) {
    std::vector<std::size_t> before;
    for (int i = 0; i < 20; ++i) before.push_back(gets(fmt::format("plug {}", i)).size());
    host.time.run_for(4s);
    for (int i = 0; i < 20; ++i) {
      const auto polled = gets(fmt::format("plug {}", i)).size() - before[static_cast<std::size_t>(i)];
      EXPECT_GE(polled, 1U) << "plug " << i;
      total += polled;
    }
  }
  EXPECT_LE(total, 130U);
  EXPECT_GE(total, 80U) << "the places are used";
}

}  // namespace
}  // namespace rubicon::networks::zigbee
