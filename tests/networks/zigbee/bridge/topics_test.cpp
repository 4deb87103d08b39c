#include "networks/zigbee/bridge/topics.h"

#include <gmock/gmock.h>

namespace rubicon::networks::zigbee::bridge {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

using Kind = Topics::Kind;

constexpr const char* kState = R"({"state":"ON","linkquality":80})";
constexpr const char* kOnline = R"({"state":"online"})";

std::string meaning(const Topics& topics, const char* topic, const char* payload = kState) {
  const auto found = topics.find(topic, payload);
  if (!found) return "unknown";
  return std::string(found->kind == Kind::kState ? "state " : "availability ") + std::string(found->entity);
}

TEST(Topics, TheBridgesOwnAreKnown) {
  const Topics topics("home/zigbee");
  EXPECT_EQ(topics.find("home/zigbee/bridge/state", "")->kind, Kind::kBridgeState);
  EXPECT_EQ(topics.find("home/zigbee/bridge/info", "")->kind, Kind::kInfo);
  EXPECT_EQ(topics.find("home/zigbee/bridge/devices", "")->kind, Kind::kDevices);
  EXPECT_EQ(topics.find("home/zigbee/bridge/groups", "")->kind, Kind::kGroups);
  EXPECT_EQ(topics.find("home/zigbee/bridge/event", "")->kind, Kind::kEvent);
  EXPECT_EQ(topics.find("home/zigbee/bridge/health", "")->kind, Kind::kHealth);
  EXPECT_EQ(topics.find("home/zigbee/bridge/response/device/rename", "")->what, "device/rename");
  EXPECT_FALSE(topics.find("home/zigbee/bridge/logging", ""));
  EXPECT_FALSE(topics.find("zigbee/bridge/state", ""));
  EXPECT_EQ(topics.request("permit_join"), "home/zigbee/bridge/request/permit_join");
}

/// Pitfall 5 of zigbee.md, section 12.
TEST(Topics, Pitfall5NamesMayHaveSlashes) {
  Topics topics("home/zigbee");
  EXPECT_THAT(topics.put("1", "first floor/bath/lamp").added,
              ElementsAre("home/zigbee/first floor/bath/lamp", "home/zigbee/first floor/bath/lamp/availability"));
  topics.put("2", "first floor/bath");
  EXPECT_EQ(meaning(topics, "home/zigbee/first floor/bath/lamp"), "state 1");
  EXPECT_EQ(meaning(topics, "home/zigbee/first floor/bath/lamp/availability"), "availability 1");
  EXPECT_EQ(meaning(topics, "home/zigbee/first floor/bath"), "state 2");
  EXPECT_EQ(meaning(topics, "home/zigbee/first floor"), "unknown");
  EXPECT_EQ(topics.set("first floor/bath"), "home/zigbee/first floor/bath/set");
  EXPECT_EQ(topics.get("first floor/bath"), "home/zigbee/first floor/bath/get");
}

/// Pitfall 13: retained availability of devices that are no longer in the list.
TEST(Topics, Pitfall13TopicsOfDevicesThatLeftAreUnknown) {
  Topics topics("z");
  topics.put("1", "lamp");
  EXPECT_THAT(topics.remove("1").removed, ElementsAre("z/lamp", "z/lamp/availability"));
  EXPECT_EQ(meaning(topics, "z/lamp/availability", kOnline), "unknown");
  EXPECT_EQ(meaning(topics, "z/lamp"), "unknown");
  EXPECT_THAT(topics.remove("1").removed, IsEmpty());
}

/// Pitfall 1: never everything below the base, where the log of the bridge doubles the traffic.
TEST(Topics, Pitfall1OnlyTheTopicsThatAreNeededAreSubscribedTo) {
  Topics topics("z");
  topics.put("1", "lamp");
  EXPECT_THAT(topics.filters(), UnorderedElementsAre("z/bridge/state", "z/bridge/info", "z/bridge/devices",
                                                     "z/bridge/groups", "z/bridge/event", "z/bridge/health",
                                                     "z/bridge/response/#", "z/lamp", "z/lamp/availability"));
}

TEST(Topics, ARenameMovesTheTopics) {
  Topics topics("z");
  topics.put("1", "lamp");
  EXPECT_THAT(topics.put("1", "lamp").added, IsEmpty());
  const auto filters = topics.put("1", "light");
  EXPECT_THAT(filters.added, ElementsAre("z/light", "z/light/availability"));
  EXPECT_THAT(filters.removed, ElementsAre("z/lamp", "z/lamp/availability"));
  EXPECT_EQ(meaning(topics, "z/light"), "state 1");
  EXPECT_EQ(meaning(topics, "z/lamp"), "unknown");
}

TEST(Topics, TwoDevicesMayExchangeTheirNames) {
  Topics topics("z");
  topics.put("1", "a");
  topics.put("2", "b");
  EXPECT_THAT(topics.put("1", "b").added, IsEmpty()) << "subscribed to already";
  EXPECT_EQ(meaning(topics, "z/b"), "state 1") << "the newest name counts";
  const auto filters = topics.put("2", "a");
  EXPECT_THAT(filters.added, ElementsAre("z/a", "z/a/availability"));
  EXPECT_THAT(filters.removed, IsEmpty());
  EXPECT_EQ(meaning(topics, "z/a"), "state 2");
  EXPECT_EQ(meaning(topics, "z/b"), "state 1");
  topics.remove("1");
  EXPECT_EQ(meaning(topics, "z/a"), "state 2");
  EXPECT_EQ(meaning(topics, "z/b"), "unknown");
}

TEST(Topics, ADeviceThatIsNamedLikeTheAvailabilityOfAnotherIsRecognizedByThePayload) {
  Topics topics("z");
  topics.put("1", "a");
  topics.put("2", "a/availability");
  EXPECT_EQ(meaning(topics, "z/a/availability", kOnline), "availability 1");
  EXPECT_EQ(meaning(topics, "z/a/availability", "offline"), "availability 1");
  EXPECT_EQ(meaning(topics, "z/a/availability", kState), "state 2");
  EXPECT_EQ(meaning(topics, "z/a/availability", ""), "state 2");
  EXPECT_EQ(meaning(topics, "z/a/availability/availability", kOnline), "availability 2");
  topics.remove("1");
  EXPECT_EQ(meaning(topics, "z/a/availability", kOnline), "state 2");
}

TEST(Topics, ADeviceThatIsNamedLikeACommandToAnotherCannotBeUsed) {
  Topics topics("z");
  topics.put("1", "a");
  for (const auto* name : {"a/set", "a/get", "a/set/brightness"}) {
    topics.put("2", name);
    EXPECT_THAT(topics.conflict("2"), HasSubstr("is a topic for commands to 'a'; rename it in Zigbee2MQTT"));
    EXPECT_FALSE(topics.find("z/" + std::string(name), kState)) << name;
  }
  EXPECT_EQ(topics.conflict("1"), "");
  EXPECT_EQ(meaning(topics, "z/a"), "state 1");
  for (const auto* name : {"b/set", "a/setting", "a/x/set", "set", "a"}) {
    topics.put("2", name);
    EXPECT_EQ(topics.conflict("2"), "") << name;
  }
  topics.put("2", "a/set");
  topics.remove("1");
  EXPECT_EQ(topics.conflict("2"), "") << "without `a` there are no commands";
  EXPECT_EQ(meaning(topics, "z/a/set"), "state 2");
}

TEST(Topics, ADeviceThatIsNamedLikeATopicOfTheBridgeCannotBeUsed) {
  Topics topics("z");
  EXPECT_THAT(topics.put("1", "bridge/state").added, ElementsAre("z/bridge/state/availability"));
  EXPECT_THAT(topics.conflict("1"), HasSubstr("topic of the bridge"));
  EXPECT_EQ(topics.find("z/bridge/state", kOnline)->kind, Kind::kBridgeState);
  EXPECT_THAT(topics.remove("1").removed, ElementsAre("z/bridge/state/availability"));
  EXPECT_THAT(topics.filters(), Contains("z/bridge/state"));
}

TEST(Topics, ABaseWithWildcardsIsRefused) {
  for (const auto* base : {"zigbee2mqtt", "a/b", "Küche"}) EXPECT_TRUE(Topics::check_base(base)) << base;
  for (const auto* base : {"", "/a", "a/", "a/#", "+", "a\n", "\xff"}) EXPECT_FALSE(Topics::check_base(base)) << base;
  EXPECT_FALSE(Topics::check_base(std::string(201, 'x')));
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
