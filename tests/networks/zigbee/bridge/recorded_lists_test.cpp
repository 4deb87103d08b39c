#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "networks/zigbee/bridge/bridge_lists.h"
#include "networks/zigbee/bridge/messages.h"
#include "networks/zigbee/bridge/settings.h"
#include "networks/zigbee/bridge/topics.h"

// Material of a real Zigbee2MQTT 2.14.1; the numbers are those of zigbee.md, section 13.
namespace rubicon::networks::zigbee::bridge {
namespace {

using testing::IsEmpty;

class RecordedLists : public testing::Test {
 protected:
  void SetUp() override {
    list_ = shared_text("bridge_devices.json");
    trace_ = shared_text("trace16-small.jsonl");
    if (list_.empty() || trace_.empty()) GTEST_SKIP() << "no ../shared/data/zigbee beside the source tree";
  }
  std::string list_, trace_;
};

TEST_F(RecordedLists, AllRecordsAreReadAndTheirLeavesCounted) {
  const std::map<std::string, std::size_t> expected{{"LCT015", 7},
                                                    {"SNZB-02", 5},
                                                    {"SP 120", 6},
                                                    {"lumi.sensor_motion.aq2", 7},
                                                    {"lumi.sensor_magnet.aq2", 8},
                                                    {"TRADFRI control outlet", 4},
                                                    {"lumi.weather", 6},
                                                    {"BASICZBR3", 2}};
  std::size_t records = 0, with_definition = 0;
  for (const auto& item : nlohmann::json::parse(list_)) {
    const auto record = read_device_record(item.dump());
    ASSERT_TRUE(record) << record.error().text;
    ++records;
    if (!item.contains("definition")) continue;
    ++with_definition;
    EXPECT_EQ(item["definition"]["exposes"].size(), expected.at(item["model_id"]));
    EXPECT_GE(record->leaves.size(), expected.at(item["model_id"])) << record->model;
    EXPECT_THAT(record->skipped, IsEmpty());
    EXPECT_EQ(why_waiting(*record), "");
    EXPECT_EQ(record->mains(), record->role == Role::kRouter);
  }
  EXPECT_EQ(records, 17U);
  EXPECT_EQ(with_definition, 16U);
}

TEST_F(RecordedLists, TheInventoryTakesTheSixteenDevices) {
  ObservedInventory seen;
  EXPECT_EQ(seen.list(list_).size(), 16U);
  EXPECT_EQ(seen.inventory.size(), 16U);
  const auto* plug = seen.inventory.find("00124b0010000002");
  ASSERT_NE(plug, nullptr);
  EXPECT_EQ(plug->model, "SP 120");
  EXPECT_EQ(plug->firmware, "1.0.0-sim");
  ASSERT_FALSE(plug->reportings.empty());
  EXPECT_EQ(plug->reportings[0], (Reporting{"genOnOff", "onOff", 0, 65000}));
}

TEST_F(RecordedLists, TheTraceJoinsSixteenDevicesAndOneLeaves) {
  ObservedInventory seen;
  Topics topics("zigbee2mqtt");
  std::map<std::string, int> counts;
  std::vector<std::string> left;
  std::istringstream lines(trace_);
  for (std::string line; std::getline(lines, line);) {
    const auto message = nlohmann::json::parse(line);
    const auto topic = message["topic"].get<std::string>();
    const auto payload = message["payload"].dump();
    const auto found = topics.find(topic, payload);
    if (!found) continue;
    if (found->kind == Topics::Kind::kDevices) seen.inventory.list(payload);
    if (found->kind == Topics::Kind::kInfo) {
      const auto bridge = read_info(payload);
      ASSERT_TRUE(bridge);
      EXPECT_TRUE(check_version(*bridge));
      EXPECT_EQ(recommendations(*bridge).size(), 2U) << "retain, and the level of the log";
    }
    if (found->kind == Topics::Kind::kBridgeState) ++counts[*read_online(payload) ? "online" : "offline"];
    if (found->kind == Topics::Kind::kEvent) {
      const auto event = read_event(payload);
      ASSERT_TRUE(event);
      ++counts[std::string(to_string(event->kind))];
      if (event->kind == BridgeEvent::Kind::kLeft) seen.inventory.leaving(event->address);
    }
    for (const auto& text : seen.run()) {
      if (text.starts_with("left")) left.push_back(text);
      EXPECT_FALSE(text.starts_with("unreadable")) << text;
    }
  }
  EXPECT_EQ(
      counts,
      (std::map<std::string, int>{
          {"joined", 16}, {"interviewing", 16}, {"interviewed", 16}, {"left", 1}, {"online", 1}, {"offline", 1}}));
  EXPECT_THAT(left, testing::ElementsAre("left 05: left the ZigBee network"));
  EXPECT_EQ(seen.inventory.size(), 15U);
  seen.inventory.each([](const auto& record, const auto& why) { EXPECT_EQ(why, "") << record.name; });
  EXPECT_EQ(seen.inventory.counters().lists, 64U);
  EXPECT_EQ(seen.inventory.counters().repeated, 24U);
  EXPECT_EQ(seen.inventory.counters().compared, 40U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
