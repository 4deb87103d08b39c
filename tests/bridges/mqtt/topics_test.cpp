#include "bridges/mqtt/town.h"

namespace rubicon::bridges::mqtt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Topics : public Town {
 protected:
  void start(const std::string& options = "{}") {
    island.network("wsn-1");
    island.device("wsn-1.7", "Kitchen mote", {{"sensor", "temperature-1", "21.5"}, {"actuator", "relay-1", "off"}},
                  "Kitchen");
    time.run_for(100ms);
    bridge(options);
  }
  static constexpr const char* kTemperature = "rubicon/6541/wsn-1/7/sensor/temperature-1";
};

TEST_F(Topics, ShowValuesAndWhoIsThere) {
  start();
  EXPECT_EQ(at(kTemperature), "21.5");
  EXPECT_EQ(at(std::string(kTemperature) + "/online"), "online");
  EXPECT_EQ(at("rubicon/6541/wsn-1/7/actuator/relay-1"), "off");
  EXPECT_EQ(at("rubicon/6541/online"), "online");
  EXPECT_EQ(at("rubicon/6541/wsn-1/online"), "online");
  EXPECT_EQ(at("rubicon/6541/wsn-1/7/online"), "online");
  EXPECT_EQ(made->status().state, "up");
}

TEST_F(Topics, FollowEachReadingAndTheNewestOfATurn) {
  start();
  broker.forget_published();
  for (const auto* value : {"22", "22", "23"}) {
    island.say("wsn-1.7", {"sensor", "temperature-1", value});
    time.run_for(10ms);
  }
  EXPECT_THAT(broker.published(kTemperature), ElementsAre("22", "22", "23")) << "a repeated reading is one too";
}

TEST_F(Topics, NeverKeepAValueThatIsNotOfNow) {
  start();
  for (const auto* quality : {"stale", "device-offline", "network-down", "bad", "stored"}) {
    island.say("wsn-1.7", {"sensor", "temperature-1", "21.5", quality});
    time.run_for(10ms);
    EXPECT_EQ(at(kTemperature), "(nothing)") << quality;
    EXPECT_EQ(at(std::string(kTemperature) + "/online"), "offline") << quality;
    island.say("wsn-1.7", {"sensor", "temperature-1", "22"});
    time.run_for(10ms);
    EXPECT_EQ(at(kTemperature), "22") << quality;
    EXPECT_EQ(at(std::string(kTemperature) + "/online"), "online") << quality;
  }
}

TEST_F(Topics, KeepOldValuesWhereTheConfigurationSaysSo) {
  start(R"({"keep": true})");
  island.say("wsn-1.7", {"sensor", "temperature-1", "21.5", "stale"});
  time.run_for(10ms);
  EXPECT_EQ(at(kTemperature), "21.5");
  EXPECT_EQ(at(std::string(kTemperature) + "/online"), "offline");
}

TEST_F(Topics, TakeAwayTheOldValueOfARunBefore) {
  broker.publish(kTemperature, "17", true);
  island.network("wsn-1");
  island.device("wsn-1.7", "Kitchen mote", {{"sensor", "temperature-1", "17", "stored"}});
  bridge();
  EXPECT_EQ(at(kTemperature), "(nothing)");
}

TEST_F(Topics, TellThatADeviceOrALineIsAway) {
  start();
  island.reach("wsn-1.7", "unreachable");
  island.network("wsn-1", "down");
  time.run_for(200ms);
  EXPECT_EQ(at("rubicon/6541/wsn-1/7/online"), "offline");
  EXPECT_EQ(at("rubicon/6541/wsn-1/online"), "offline");
}

TEST_F(Topics, TellTheEndInOrderAndByTheWill) {
  start();
  broker.cut();
  EXPECT_EQ(at("rubicon/6541/online"), "offline") << "the will";
  time.run_for(2s);
  EXPECT_EQ(at("rubicon/6541/online"), "online") << "it came back by itself";
  end_bridge();
  EXPECT_EQ(at("rubicon/6541/online"), "offline");
}

TEST_F(Topics, ComeAgainToABrokerThatLostAll) {
  start();
  for (int i = 0; i < 20; ++i) {
    broker.stop(false);
    time.run_for(3s);
    broker.start();
    island.say("wsn-1.7", {"sensor", "temperature-1", std::to_string(20 + i)});
    time.run_for(40s);
    ASSERT_EQ(at(kTemperature), std::to_string(20 + i)) << i;
    ASSERT_EQ(at("rubicon/6541/wsn-1/7/online"), "online") << i;
  }
}

TEST_F(Topics, OfADeviceThatLeavesAreRemoved) {
  start();
  island.remove_device("wsn-1.7");
  time.run_for(1s);
  for (const auto& [topic, payload] : broker.retained()) EXPECT_EQ(topic.find("/7/"), topic.npos) << topic;
}

TEST_F(Topics, LeftByARunBeforeAreRemovedOnceTheDevicesHadTimeToCome) {
  broker.publish("rubicon/6541/wsn-1/9/sensor/temperature-1", "17", true);
  broker.publish("rubicon/6541/wsn-1/9/online", "online", true);
  broker.publish("rubicon/77/wsn-1/9/online", "online", true);
  broker.publish("homeassistant/device/rubicon_6541_wsn-1_9/config",
                 R"({"o":{"name":"rubicon"},"avty":[{"t":"rubicon/6541/online"}]})", true);
  broker.publish("homeassistant/sensor/other/x/config", R"({"o":{"name":"zigbee2mqtt"}})", true);
  start(R"({"discovery": "homeassistant"})");
  EXPECT_EQ(at("rubicon/6541/wsn-1/9/online"), "online") << "it may be slow";
  time.run_for(61s);
  EXPECT_EQ(at("rubicon/6541/wsn-1/9/sensor/temperature-1"), "(nothing)");
  EXPECT_EQ(at("rubicon/6541/wsn-1/9/online"), "(nothing)");
  EXPECT_EQ(at("homeassistant/device/rubicon_6541_wsn-1_9/config"), "(nothing)");
  EXPECT_EQ(at("rubicon/77/wsn-1/9/online"), "online") << "of another island";
  EXPECT_NE(at("homeassistant/sensor/other/x/config"), "(nothing)");
  EXPECT_EQ(at(kTemperature), "21.5");
}

TEST_F(Topics, OfEventsAreNeitherKeptNorRepeated) {
  island.network("zigbee-1");
  island.device("zigbee-1.b", "Button", {{"sensor", "button-1", "short"}});
  time.run_for(1s);
  bridge();
  const std::string topic = "rubicon/6541/zigbee-1/b/sensor/button-1";
  EXPECT_THAT(broker.published(topic), IsEmpty()) << "pressed before we looked";
  for (const auto* word : {"short", "", "long", "", "long"}) {
    island.say("zigbee-1.b", {"sensor", "button-1", word});
    time.run_for(10ms);
  }
  EXPECT_THAT(broker.published(topic), ElementsAre("short", "long", "long"));
  EXPECT_EQ(at(topic), "(nothing)");
}

TEST_F(Topics, AreThoseOfTheOwnIslandUnlessPatternsSayMore) {
  TownIsland other(ecology, time, OwnerId(77), "barn");
  other.network("knx");
  other.device("knx.1_1_1", "Door", {{"sensor", "contact-1", "open"}});
  start();
  EXPECT_EQ(at("rubicon/77/knx/1_1_1/sensor/contact-1"), "(nothing)");
  end_bridge();
  bridge(R"({"patterns": ["proxy.**"], "except": ["proxy.wsn-1.7.actuator.*.value"]})");
  EXPECT_EQ(at("rubicon/77/knx/1_1_1/sensor/contact-1"), "open");
  EXPECT_EQ(at("rubicon/77/online"), "online");
  EXPECT_EQ(broker.published("rubicon/6541/wsn-1/7/actuator/relay-1").size(), 1U) << "only before";
}

TEST_F(Topics, OfAnIslandThatIsLostGoOffline) {
  auto other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  other->network("knx");
  other->device("knx.1_1_1", "Door", {{"sensor", "contact-1", "open"}});
  start(R"({"patterns": ["proxy.**"]})");
  const std::string network = "rubicon/77/knx", door = network + "/1_1_1", contact = door + "/sensor/contact-1";
  EXPECT_EQ(at(contact), "open");
  other.reset();
  time.run_for(2min);
  EXPECT_EQ(at("rubicon/77/online"), "offline");
  EXPECT_EQ(at(network + "/online"), "offline");
  EXPECT_EQ(at(door + "/online"), "offline") << "it is not removed: the island comes back";
  EXPECT_EQ(at(contact), "(nothing)") << "it is not a value of now";
  EXPECT_EQ(at(contact + "/online"), "offline");
  other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  other->network("knx");
  other->device("knx.1_1_1", "Door", {{"sensor", "contact-1", "closed"}});
  time.run_for(1s);
  EXPECT_EQ(at(contact), "closed");
  for (const auto& topic : {network, door, contact}) EXPECT_EQ(at(topic + "/online"), "online") << topic;
}

TEST_F(Topics, OfDevicesThatALostIslandDoesNotBringBackAreRemoved) {
  auto other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  other->network("knx");
  other->network("old");
  other->device("old.1", "Door", {{"sensor", "contact-1", "open"}});
  other->device("knx.1", "Door", {{"sensor", "contact-1", "open"}, {"sensor", "contact-2", "open"}});
  other->device("knx.2", "Door", {{"sensor", "contact-1", "open"}});
  start(R"({"patterns": ["proxy.**"]})");
  other.reset();
  time.run_for(2min);
  other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  other->network("knx");
  other->device("knx.1", "Door", {{"sensor", "contact-1", "open"}});
  time.run_for(30s);
  EXPECT_EQ(at("rubicon/77/knx/2/online"), "offline") << "it may be slow";
  time.run_for(60s);
  for (const auto* gone : {"old", "old/1", "knx/2", "knx/1/sensor/contact-2"})
    EXPECT_EQ(at(std::string("rubicon/77/") + gone + "/online"), "(nothing)") << gone;
  EXPECT_EQ(at("rubicon/77/knx/1/sensor/contact-1"), "open");
  EXPECT_EQ(at("rubicon/77/knx/1/online"), "online");
  EXPECT_EQ(made->status().counters.at("points"), 3U) << "two are of the other island";
}

TEST_F(Topics, OfAnIslandThatDoesNotComeBackAreRemovedAfterAWeek) {
  const auto open_barn = [this] {
    auto barn = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
    barn->network("knx");
    barn->device("knx.1", "Door", {{"sensor", "contact-1", "open"}, {"actuator", "relay-1", "off"}});
    return barn;
  };
  const std::string config = "homeassistant/device/rubicon_77_knx_1/config";
  auto other = open_barn();
  start(R"({"patterns": ["proxy.**"], "discovery": "homeassistant"})");
  time.run_for(6s);
  ASSERT_NE(at(config), "(nothing)");
  other.reset();
  time.run_for(6 * 24h);
  EXPECT_EQ(at("rubicon/77/online"), "offline");
  EXPECT_NE(at(config), "(nothing)") << "a holiday";
  other = open_barn();
  time.run_for(1h);
  EXPECT_EQ(at("rubicon/77/knx/1/sensor/contact-1"), "open");
  other.reset();
  time.run_for(6 * 24h);
  EXPECT_EQ(at("rubicon/77/knx/1/online"), "offline") << "a week since it was there the last time";
  time.run_for(25h);
  for (const auto& [topic, payload] : broker.retained()) EXPECT_EQ(topic.find("77"), topic.npos) << topic;
  EXPECT_EQ(made->status().counters.at("devices"), 1U);
  EXPECT_EQ(made->status().counters.at("points"), 2U);
  EXPECT_EQ(at(kTemperature), "21.5");
  broker.cut();
  time.run_for(2min);
  for (const auto& [topic, payload] : broker.retained()) EXPECT_EQ(topic.find("77"), topic.npos) << topic;
  other = open_barn();
  time.run_for(1s);
  EXPECT_EQ(at("rubicon/77/online"), "online");
  EXPECT_EQ(at("rubicon/77/knx/1/sensor/contact-1"), "open");
  EXPECT_NE(at(config), "(nothing)");
}

/// With names of people, an island that got another id stands at the topics of the former one.
TEST_F(Topics, OfAnIslandUnderANewIdStayWhenTheFormerOneIsRemoved) {
  const auto open_barn = [this](std::uint32_t id) {
    auto barn = std::make_unique<TownIsland>(ecology, time, OwnerId(id), "barn");
    barn->network("knx");
    barn->device("knx.1", "", {{"sensor", "contact-1", "open"}, {"actuator", "relay-1", "off"}});
    return barn;
  };
  auto barn = open_barn(77);
  start(R"({"patterns": ["proxy.**"], "names": "friendly", "keep": true, "commands": ["proxy.**"]})");
  time.run_for(6s);
  barn.reset();
  time.run_for(1min);
  barn = open_barn(78);
  time.run_for(8 * 24h);
  for (const auto* topic : {"rubicon/barn/online", "rubicon/barn/knx/online", "rubicon/barn/knx/1/online"})
    EXPECT_EQ(at(topic), "online") << topic;
  EXPECT_EQ(at("rubicon/barn/knx/1/sensor/contact-1"), "open");
  broker.publish({"rubicon/barn/knx/1/actuator/relay-1/set", "on"});
  time.run_for(1s);
  EXPECT_EQ(made->status().counters.at("commands-refused"), 0U);
}

constexpr const char* kOurBroker = R"({"host":"127.0.0.1","port":1883,"tls":false,"user":false})";
constexpr const char* kOtherBroker = R"({"host":"barn.lan","port":1883,"tls":false,"user":false})";

TEST_F(Topics, AreShownOnceTheirNetworkIsAtAnotherBroker) {
  const std::string origin = "proxy.zigbee-1.property.broker.value", device = "rubicon/6541/zigbee-1/b";
  island.network("zigbee-1");
  island.put(origin, kOurBroker);
  island.device("zigbee-1.b", "Plug", {{"actuator", "switch-1", "on"}, {"sensor", "button-1", ""}});
  start(R"({"discovery": "homeassistant"})");
  island.say("zigbee-1.b", {"sensor", "button-1", "short"});
  time.run_for(6s);
  for (const auto* broker_now : {kOtherBroker, ""}) {
    EXPECT_EQ(at(device + "/actuator/switch-1"), "(nothing)");
    if (broker_now == std::string()) {
      ASSERT_TRUE(island.space.erase(origin));
    } else {
      island.put(origin, broker_now);
    }
    time.run_for(1s);
    EXPECT_EQ(at(device + "/actuator/switch-1"), "on");
    EXPECT_EQ(at(device + "/online"), "online");
    EXPECT_EQ(at("rubicon/6541/zigbee-1/online"), "online");
    EXPECT_FALSE(announced("zigbee-1_b").is_discarded());
    EXPECT_THAT(broker.published(device + "/sensor/button-1"), IsEmpty()) << "pressed while it was hidden";
    island.put(origin, kOurBroker);
    time.run_for(1s);
    for (const auto& [topic, payload] : broker.retained()) EXPECT_EQ(topic.find("zigbee-1"), topic.npos) << topic;
  }
}

TEST_F(Topics, AreShownWhereALostIslandComesBackWithoutThatBroker) {
  const auto open_barn = [this](const std::string& at_broker) {
    auto barn = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
    barn->network("zigbee-1");
    if (!at_broker.empty()) barn->put("proxy.zigbee-1.property.broker.value", at_broker);
    barn->device("zigbee-1.b", "Plug", {{"actuator", "switch-1", "on"}});
    return barn;
  };
  const std::string plug = "rubicon/77/zigbee-1/b/actuator/switch-1";
  auto other = open_barn(kOurBroker);
  start(R"({"patterns": ["proxy.**"]})");
  other.reset();
  time.run_for(2min);
  other = open_barn({});
  time.run_for(30s);
  EXPECT_EQ(at(plug), "(nothing)") << "its broker may be told late";
  time.run_for(60s);
  EXPECT_EQ(at(plug), "on");
}

TEST_F(Topics, NeverGoBackToTheBrokerTheyCameFrom) {
  island.network("zigbee-1");
  island.put("proxy.zigbee-1.property.broker.value", kOurBroker);
  island.device("zigbee-1.b", "Plug", {{"actuator", "switch-1", "on"}});
  island.network("zigbee-2");
  island.put("proxy.zigbee-2.property.broker.value", kOtherBroker);
  island.device("zigbee-2.c", "Plug", {{"actuator", "switch-1", "on"}});
  start(R"({"discovery": "homeassistant"})");
  time.run_for(6s);
  for (const auto& [topic, payload] : broker.retained()) EXPECT_EQ(topic.find("zigbee-1"), topic.npos) << topic;
  EXPECT_EQ(at("rubicon/6541/zigbee-2/c/actuator/switch-1"), "on");
}

TEST_F(Topics, AreOnlyThoseThatTheRightsLetItRead) {
  judge->replace(
      rights::Rights({support::rule("bridge:ha", {support::Right::kRead}, {"proxy.wsn-1.7.sensor.*.value"})}));
  start();
  EXPECT_EQ(at(kTemperature), "21.5");
  EXPECT_EQ(at("rubicon/6541/wsn-1/7/actuator/relay-1"), "(nothing)");
}

TEST_F(Topics, HaveTheNamesOfPeopleOnRequest) {
  start(R"({"names": "friendly"})");
  EXPECT_EQ(at("rubicon/home/wsn-1/Kitchen mote/sensor/temperature-1"), "21.5");
  island.device("wsn-1.8", "Kitchen mote", {{"sensor", "temperature-1", "19"}});
  island.device("wsn-1.9", "a/b+#", {{"sensor", "temperature-1", "18"}});
  time.run_for(1s);
  EXPECT_EQ(at("rubicon/home/wsn-1/Kitchen mote (8)/sensor/temperature-1"), "19");
  EXPECT_EQ(at("rubicon/home/wsn-1/a_b__/sensor/temperature-1"), "18");
}

TEST_F(Topics, HaveObjectsForDatabases) {
  start(R"({"payload": "json"})");
  EXPECT_EQ(json::parse(at(kTemperature)), json::parse(R"({"value":21.5,"unit":"Cel","quality":"good",
      "time":1767225600})"));
  EXPECT_EQ(json::parse(at("rubicon/6541/wsn-1/7/actuator/relay-1"))["value"], 0) << "booleans are numbers";
  island.say("wsn-1.7", {"sensor", "temperature-1", "21.5", "stale"});
  time.run_for(10ms);
  EXPECT_EQ(json::parse(at(kTemperature))["value"], nullptr);
  EXPECT_EQ(json::parse(at(kTemperature))["quality"], "stale");
}

TEST_F(Topics, HaveAttributesOnRequestAtMostOnceASecond) {
  start(R"({"attributes": true, "discovery": "homeassistant"})");
  const auto topic = std::string(kTemperature) + "/attributes";
  time.run_for(6s);
  EXPECT_EQ(json::parse(
                at("homeassistant/device/rubicon_6541_wsn-1_7/config"))["cmps"]["sensor-temperature-1"]["json_attr_t"],
            topic);
  broker.forget_published();
  for (int i = 0; i < 20; ++i) {
    island.say("wsn-1.7", {"sensor", "temperature-1", "22", i % 2 == 0 ? "stale" : "good"});
    time.run_for(100ms);
  }
  time.run_for(1s);
  const auto all = broker.published(topic);
  ASSERT_THAT(all.size(), ::testing::AllOf(::testing::Ge(2U), ::testing::Le(3U)));
  const auto last = json::parse(all.back());
  EXPECT_EQ(last["quality"], "good");
  EXPECT_EQ(last["unit"], "Cel");
  EXPECT_GT(last["heard"], 1767225600) << "seconds since 1970";
  EXPECT_EQ(at(topic), "(nothing)") << "not retained";
}

TEST_F(Topics, WakeNoSensorUnlessAskedTo) {
  std::vector<std::string> wanted;
  const auto watch = island.space.watch_demand(Pattern::parse("proxy.**").value(), [&](const tuples::Demand& demand) {
    wanted.push_back((demand.wanted ? "+" : "-") + std::string(demand.key));
  });
  start();
  EXPECT_THAT(wanted, IsEmpty());
  end_bridge();
  bridge(R"({"demand": {"active": ["proxy.*.*.sensor.temp*.value"]}})");
  EXPECT_THAT(wanted, ElementsAre("+proxy.wsn-1.7.sensor.temperature-1.value"));
  end_bridge();
  wanted.clear();
  bridge(R"({"demand": "on-request"})");
  send(std::string(kTemperature) + "/sample", "5s");
  EXPECT_THAT(wanted, ElementsAre("+proxy.wsn-1.7.sensor.temperature-1.value"));
  time.run_for(6s);
  EXPECT_THAT(wanted,
              ElementsAre("+proxy.wsn-1.7.sensor.temperature-1.value", "-proxy.wsn-1.7.sensor.temperature-1.value"));
}

TEST_F(Topics, GoOnBehindASlowBrokerWithTheNewestValues) {
  start();
  broker.stall(true);
  for (int i = 0; i < 30'000; ++i) {
    island.say("wsn-1.7", {"sensor", "temperature-1", std::to_string(i)});
    time.run_for(100us);
  }
  broker.stall(false);
  time.run_for(5s);
  EXPECT_EQ(at(kTemperature), "29999");
  EXPECT_EQ(made->status().counters.at("dropped"), 0U);
}

TEST_F(Topics, NeedAnOlderBrokerOnlyToSpeak311) {
  broker.speaks_5 = false;
  start();
  EXPECT_EQ(at(kTemperature), "21.5");
}

TEST_F(Topics, ABrokerThatRetainsNothingIsNamed) {
  broker.retains = false;
  start();
  EXPECT_THAT(made->status().reason + " " + made->status().state,
              ::testing::AnyOf(HasSubstr("retains"), HasSubstr("connecting")));
}

TEST_F(Topics, AnAccessListThatHidesThemIsNamed) {
  broker.ignored_topics = {"rubicon/+/+/+/+/+"};
  start();
  EXPECT_EQ(made->status().reason, "") << "it may be slow";
  time.run_for(61s);
  EXPECT_THAT(made->status().reason, HasSubstr("access list"));
  broker.ignored_topics.clear();
  broker.cut();
  time.run_for(70s);
  EXPECT_EQ(made->status().reason, "");
}

TEST_F(Topics, APasswordThatIsRefusedIsTriedSeldom) {
  broker.users = {{"rubicon", "secret"}};
  files.put("/secret", "wrong\n");
  start(R"({"broker": {"host": "localhost", "user": "rubicon", "password-file": "/secret"}})");
  EXPECT_EQ(made->status().state, "refused");
  files.put("/secret", "secret\n");
  time.run_for(60s);
  EXPECT_EQ(made->status().state, "up");
}

TEST_F(Topics, RefuseBasesOfOthers) {
  for (const auto* base : {"rubicon-space", "$SYS", "homeassistant", "a/+/b", "", "/a"}) {
    const auto options = support::config_of(nlohmann::ordered_json{{"broker", "localhost"}, {"base", base}});
    base::ConfigErrors errors;
    ConfigReader reader(options, "bridges.ha", errors);
    EXPECT_EQ(find_bridge_type("mqtt")->make(reader, "", nullptr), nullptr);
    EXPECT_THAT(errors.text(), HasSubstr("base")) << base;
  }
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
