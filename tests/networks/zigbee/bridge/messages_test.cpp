#include "networks/zigbee/bridge/messages.h"

#include <gmock/gmock.h>

#include <chrono>

#include "networks/zigbee/bridge/settings.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kInfo = R"({"version":"2.14.1","coordinator":{"type":"EZSP","ieee_address":"0x00124B00deadbeef"},
  "network":{"channel":15},"permit_join":true,"permit_join_end":1795220257825,"restart_required":true,"unknown":[],
  "config":{"advanced":{"output":"json","last_seen":"ISO_8601","log_level":"warning","cache_state":true},
    "mqtt":{"base_topic":"home/zigbee","server":"mqtt://secret@host","force_disable_retain":false},
    "availability":{"enabled":true,"active":{"timeout":10},"passive":{"timeout":1500}},
    "device_options":{"optimistic":false,"retain":true},
    "devices":{"0x00124b0000000001":{"friendly_name":"lamp","optimistic":true},
               "0x00124b0000000002":{"friendly_name":"plug","availability":{"timeout":5}},
               "0x00124b0000000003":{"friendly_name":"fan","availability":false},
               "0x00124b0000000004":{"friendly_name":"bulb"},"nonsense":{"optimistic":true},"0x1":7},
    "groups":{"7":{"friendly_name":"lamps","optimistic":true}}}})";

TEST(BridgeMessages, OnlineIsReadInBothForms) {
  EXPECT_EQ(*read_online(R"({"state":"online"})"), true);
  EXPECT_EQ(*read_online(R"( {"state" : "offline"} )"), false);
  EXPECT_EQ(*read_online("online"), true);
  EXPECT_EQ(*read_online("offline\n"), false);
  for (const auto* text : {"", "{}", "1", "null", "[]", "Online", R"({"state":"ON"})", R"({"state":"online","x":1})"}) {
    EXPECT_FALSE(read_online(text)) << text;
  }
}

TEST(BridgeMessages, InfoNamesTheBridgeAndItsSettings) {
  const auto bridge = read_info(kInfo);
  ASSERT_TRUE(bridge) << bridge.error().text;
  EXPECT_EQ(bridge->version, "2.14.1");
  EXPECT_EQ(bridge->coordinator, "EZSP");
  EXPECT_EQ(bridge->coordinator_address, "00124b00deadbeef");
  EXPECT_EQ(bridge->channel, 15U);
  EXPECT_TRUE(bridge->permit_join);
  EXPECT_EQ(bridge->permit_join_end, WallTime(1795220257825ms));
  EXPECT_TRUE(bridge->restart_required);
  EXPECT_TRUE(bridge->last_seen_published());
  EXPECT_TRUE(bridge->retained);
}

TEST(BridgeMessages, OptionsOfADeviceGoBeforeThoseOfAll) {
  const auto bridge = read_info(kInfo);
  ASSERT_TRUE(bridge);
  EXPECT_TRUE(bridge->optimistic("00124b0000000001"));
  EXPECT_FALSE(bridge->optimistic("00124b0000000002"));
  EXPECT_TRUE(bridge->optimistic("group-7"));
  EXPECT_TRUE(bridge->availability("00124b0000000001"));
  EXPECT_TRUE(bridge->availability("00124b0000000002"));
  EXPECT_FALSE(bridge->availability("00124b0000000003"));
  EXPECT_EQ(bridge->of.size(), 4U) << "only those that have options";
  EXPECT_TRUE(BridgeDescription{}.optimistic("00124b0000000001"));
  EXPECT_FALSE(BridgeDescription{}.availability("00124b0000000001"));
}

TEST(BridgeMessages, InfoOfAnotherShapeHasTheDefaultsOfTheBridge) {
  for (const auto* text : {"{}", R"({"config":null,"coordinator":[],"permit_join":"yes"})",
                           R"({"config":{"advanced":7,"mqtt":[],"availability":"on","devices":[],"device_options":1}})",
                           R"({"permit_join_end":1e300,"network":{"channel":-4}})"}) {
    const auto bridge = read_info(text);
    ASSERT_TRUE(bridge) << text;
    EXPECT_EQ(*bridge, BridgeDescription{}) << text;
  }
  EXPECT_EQ(read_info(R"({"config":{"availability":true}})")->availability_enabled, true);
  EXPECT_FALSE(read_info("[]"));
  EXPECT_FALSE(read_info("{"));
}

TEST(BridgeMessages, ABridgeOfVersion1IsRefusedWithTheReason) {
  const auto check = [](const char* version) {
    BridgeDescription bridge;
    bridge.version = version;
    return check_version(bridge);
  };
  EXPECT_TRUE(check("2.0.0"));
  EXPECT_TRUE(check("2.14.1-dev"));
  EXPECT_TRUE(check("10.0"));
  EXPECT_TRUE(check("3"));
  const auto old = check("1.42.0");
  ASSERT_FALSE(old);
  EXPECT_EQ(old.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(old.error().text, "Zigbee2MQTT 1.42.0 is too old: version 2.0 or later is needed; update it");
  EXPECT_THAT(check("").error().text, HasSubstr("cannot be read"));
  EXPECT_THAT(check("two\n").error().text, HasSubstr("'two '"));
}

TEST(BridgeMessages, EventsNameTheDevice) {
  const auto event = [](const char* type, const char* more) {
    return read_event(std::string(R"({"type":")") + type +
                      R"(","data":{"friendly_name":"lamp","ieee_address":"0x00124b0000000001")" + more + "}}");
  };
  using Kind = BridgeEvent::Kind;
  EXPECT_EQ(event("device_joined", "")->kind, Kind::kJoined);
  EXPECT_EQ(event("device_announce", "")->kind, Kind::kAnnounced);
  EXPECT_EQ(event("device_leave", R"(,"friendly_name":null)")->kind, Kind::kLeft);
  EXPECT_EQ(event("device_interview", R"(,"status":"started")")->kind, Kind::kInterviewing);
  EXPECT_EQ(event("device_interview", R"(,"status":"failed")")->kind, Kind::kFailed);
  EXPECT_EQ(event("device_interview", R"(,"status":"new")")->kind, Kind::kOther);
  EXPECT_EQ(event("device_options_changed", "")->kind, Kind::kOther);
  const auto done = event("device_interview", R"(,"status":"successful","supported":true,"definition":
    {"vendor":"V","model":"M","description":"D","exposes":[]})");
  ASSERT_TRUE(done);
  EXPECT_EQ(*done,
            (BridgeEvent{Kind::kInterviewed, "device_interview", "00124b0000000001", "lamp", "V", "M", "D", true}));
  EXPECT_EQ(to_string(done->kind), "interviewed");
}

TEST(BridgeMessages, AnEventWithoutAnAddressCannotBeRead) {
  EXPECT_FALSE(read_event(R"({"type":"device_joined","data":{}})"));
  EXPECT_FALSE(read_event(R"({"type":"device_leave"})"));
  EXPECT_FALSE(read_event(R"({"type":"device_leave","data":{"ieee_address":"lamp"}})"));
  EXPECT_FALSE(read_event("nonsense"));
  EXPECT_EQ(read_event("{}")->kind, BridgeEvent::Kind::kOther);
}

TEST(BridgeMessages, ResponsesCarryTheBridgesOwnText) {
  const auto good = read_response(R"({"data":{"from":"x","to":"y"},"status":"ok","transaction":"1"})");
  ASSERT_TRUE(good);
  EXPECT_EQ(*good, (BridgeResponse{true, "", "1", R"({"from":"x","to":"y"})"}));
  const auto bad =
      read_response(R"({"data":{},"error":"Device 'x'\ndoes not exist","status":"error","transaction":9})");
  ASSERT_TRUE(bad);
  EXPECT_EQ(*bad, (BridgeResponse{false, "Device 'x' does not exist", "9", "{}"}));
  EXPECT_EQ(read_response("{}")->error, "the bridge gave no reason");
  EXPECT_EQ(read_response(R"({"status":"ok","data":[1]})")->data, "{}");
  EXPECT_FALSE(read_response(""));
}

TEST(BridgeMessages, AMapHasNodesAndLinks) {
  const auto map = read_network_map(R"({"type":"raw","routes":false,"value":{
    "nodes":[{"ieeeAddr":"0x00124b0000000000","friendlyName":"Coordinator","type":"Coordinator","failed":[]},
             {"ieeeAddr":"0x00124b0000000001","friendlyName":"lamp","type":"Router","failed":["lqi",3],
              "manufacturerName":"m","definition":{"vendor":"V","model":"M"}},"nonsense"],
    "links":[{"source":{"ieeeAddr":"0x00124b0000000001"},"target":{"ieeeAddr":"0x00124b0000000000"},
              "linkquality":120,"depth":1,"relationship":1},{"relationship":9},{},7]}})");
  ASSERT_TRUE(map) << map.error().text;
  ASSERT_EQ(map->nodes.size(), 2U);
  EXPECT_EQ(map->nodes[1].address, "00124b0000000001");
  EXPECT_EQ(map->nodes[1].vendor, "V");
  EXPECT_THAT(map->nodes[1].failed, ElementsAre("lqi"));
  ASSERT_EQ(map->links.size(), 3U);
  EXPECT_EQ(map->links[0].source, "00124b0000000001");
  EXPECT_EQ(map->links[0].target, "00124b0000000000");
  EXPECT_EQ(map->links[0].quality, 120U);
  EXPECT_EQ(map->links[0].relation, "child");
  EXPECT_EQ(map->links[1].relation, "");
  EXPECT_EQ(map->links[2].relation, "");
  EXPECT_FALSE(read_network_map(R"({"type":"graphviz","value":"digraph"})"));
}

TEST(BridgeMessages, HealthCountsMessages) {
  const auto health = read_health(R"({"response_time":1795220257825,
    "os":{"load_average":[0.5,0.4,0.3],"memory_used_mb":900,"memory_percent":40.5},
    "process":{"uptime_sec":3600,"memory_used_mb":150.5,"memory_percent":7},
    "mqtt":{"connected":true,"queued":3,"published":100,"received":20},
    "devices":{"0x00124b0000000001":{"messages":7,"messages_per_sec":0.25,"leave_count":1,"network_address_changes":2},
               "lamp":{"messages":7},"0x00124b0000000002":null}})");
  ASSERT_TRUE(health);
  EXPECT_EQ(health->time, WallTime(1795220257825ms));
  EXPECT_EQ(health->load, 0.5);
  EXPECT_EQ(health->memory_mb, 150.5);
  EXPECT_EQ(health->uptime_seconds, 3600);
  EXPECT_TRUE(health->mqtt_connected);
  EXPECT_EQ(health->mqtt_queued, 3U);
  ASSERT_EQ(health->devices.size(), 1U);
  EXPECT_EQ(health->devices.at("00124b0000000001").messages, 7U);
  EXPECT_EQ(health->devices.at("00124b0000000001").address_changes, 2U);
  EXPECT_TRUE(read_health("{}"));
  EXPECT_FALSE(read_health("[]"));
}

TEST(BridgeMessages, NestedTooDeepOrTooLongIsNotRead) {
  const std::string deep = R"({"config":)" + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  EXPECT_THAT(read_info(deep).error().text, HasSubstr("bridge/info"));
  EXPECT_FALSE(read_event(deep));
  EXPECT_FALSE(read_response(deep));
  EXPECT_FALSE(read_health(std::string(kMaxMessageBytes + 1, ' ')));
  EXPECT_EQ(read_info(R"({"version":")" + std::string(5000, 'x') + "\"}")->version.size(), 512U);
}

std::vector<std::string> names(const std::vector<Recommendation>& recommendations) {
  std::vector<std::string> all;
  for (const auto& one : recommendations) all.push_back(one.setting + "=" + one.is + ", not " + one.should);
  return all;
}

TEST(Recommendations, NameWhatDiffersAndWhy) {
  EXPECT_THAT(recommendations(*read_info(kInfo)), testing::IsEmpty());
  BridgeDescription bridge;
  EXPECT_THAT(names(recommendations(bridge)),
              ElementsAre("advanced.last_seen=disable, not ISO_8601", "availability.enabled=false, not true",
                          "device_options.retain=false, not true", "advanced.log_level=info, not warning"));
  bridge.output = "attribute";
  bridge.retained = bridge.cache_state = false;
  bridge.last_seen = "epoch";
  bridge.log_level = "error";
  bridge.availability_enabled = true;
  bridge.all.retain = true;
  EXPECT_THAT(names(recommendations(bridge)),
              ElementsAre("advanced.output=attribute, not json", "mqtt.force_disable_retain=true, not false",
                          "advanced.cache_state=false, not true"));
  for (const auto& one : recommendations(bridge)) EXPECT_GT(one.why.size(), 20U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
