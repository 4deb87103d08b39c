#include <set>
#include <string>
#include <variant>

#include "bridges/mqtt/town.h"
#include "model/message.h"
#include "rights/rights.h"
#include "verbs/requests.h"

namespace rubicon::bridges::mqtt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Commands : public Town {
 protected:
  void start(const std::string& options = R"({"commands": "yes"})") {
    island.network("knx");
    island.device("knx.1", "Hall", {kLamp, {"actuator", "lock-1", "locked"}, {"property", "interval-1", "5"}});
    time.run_for(100ms);
    bridge(options);
    broker.forget_published();
  }
  inline static const Described kLamp{"actuator", "lamp-1", "off"};
  static constexpr const char* kTopic = "rubicon/6541/knx/1/actuator/lamp-1";
  static constexpr const char* kSet = "rubicon/6541/knx/1/actuator/lamp-1/set";
};

TEST_F(Commands, SetTheTupleAndAnswerWithTheOutcome) {
  start();
  send(kSet, "on");
  ASSERT_EQ(island.sets.size(), 1U);
  EXPECT_EQ(island.sets[0].key, "proxy.knx.1.actuator.lamp-1.command");
  EXPECT_EQ(island.sets[0].value, "on");
  EXPECT_EQ(island.sets[0].asker, "bridge:ha");
  EXPECT_EQ(outcome(kTopic), "(none)") << "it is under way";
  island.report("knx.1", {"actuator", "lamp-1", "on"}, "confirmed");
  time.run_for(100ms);
  EXPECT_EQ(outcome(kTopic), "confirmed");
  EXPECT_EQ(at(kTopic), "on") << "by the report of the device only";
  EXPECT_THAT(audit->lines, ElementsAre("bridge:ha set proxy.knx.1.actuator.lamp-1.command: accepted"));
}

TEST_F(Commands, LiveAsLongAsTheirMessage) {
  start();
  send(kSet, "on");
  EXPECT_LE(island.sets.back().time_to_live, 5s);
  broker.publish({kSet, "on", false, 1, transport::MqttQueue::kInOrder, 60s});
  time.run_for(100ms);
  EXPECT_GT(island.sets.back().time_to_live, 50s);
}

TEST_F(Commands, AnswerWhereTheyAreAskedTo) {
  start();
  transport::MqttPublication ask{kSet, "on"};
  ask.response_topic = "panel/answers";
  ask.correlation = "17";
  broker.publish(ask);
  time.run_for(100ms);
  island.report("knx.1", {"actuator", "lamp-1", "on"}, "confirmed");
  time.run_for(100ms);
  ASSERT_EQ(broker.published("panel/answers").size(), 1U);
  const auto& all = broker.published();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& one) { return one.topic == "panel/answers"; });
  EXPECT_EQ(found->correlation, "17");
  ask.response_topic = "rubicon/6541/knx/1/actuator/lock-1/set";
  broker.publish(ask);
  time.run_for(30s);  // it ends by its time
  EXPECT_THAT(broker.published(ask.response_topic), IsEmpty()) << "an answer is not a command";
}

TEST_F(Commands, ThatAreRefusedCorrectTheSwitch) {
  start();
  island.refuses = "the line is down";
  send(kSet, "on");
  EXPECT_EQ(outcome(kTopic), "refused");
  EXPECT_THAT(broker.published(kTopic), ElementsAre("off")) << "the present state, again";
}

TEST_F(Commands, OfARunBeforeAreIgnored) {
  broker.publish(kSet, "on", true);
  start();
  EXPECT_THAT(island.sets, IsEmpty());
}

TEST_F(Commands, AreNotTakenUnlessTheConfigurationSaysSo) {
  start("{}");
  send(kSet, "on");
  EXPECT_THAT(island.sets, IsEmpty());
}

TEST_F(Commands, UsualOnesOpenNoDoorAndChangeNoProperty) {
  start();
  for (const auto* topic : {"rubicon/6541/knx/1/actuator/lock-1", "rubicon/6541/knx/1/property/interval-1"}) {
    send(std::string(topic) + "/set", "unlocked");
    EXPECT_EQ(outcome(topic), "refused") << topic;
  }
  EXPECT_THAT(island.sets, IsEmpty());
  EXPECT_THAT(audit->lines, ElementsAre("bridge:ha set proxy.knx.1.actuator.lock-1.command: refused",
                                        "bridge:ha set proxy.knx.1.property.interval-1.command: refused"));
}

TEST_F(Commands, PatternsSayMore) {
  start(R"({"commands": ["proxy.knx.*.property.inter*.command"]})");
  send("rubicon/6541/knx/1/property/interval-1/set", "7");
  ASSERT_EQ(island.sets.size(), 1U);
  EXPECT_EQ(island.sets[0].value, "7");
  send(kSet, "on");
  EXPECT_EQ(island.sets.size(), 1U);
}

TEST_F(Commands, NeedTheRightsOfTheBridgeToo) {
  judge->replace(rights::Rights(
      {support::rule("bridge:ha", {support::Right::kRead}), support::rule("everybody", {support::Right::kRead})}));
  start();
  send(kSet, "on");
  EXPECT_EQ(outcome(kTopic), "refused");
  EXPECT_THAT(island.sets, IsEmpty());
  EXPECT_THAT(audit->whys, ElementsAre(HasSubstr("no rule allows it")));
}

/// Kinds of messages, rights, and verbs of requests.
std::set<std::string> all_verbs() {
  std::set<std::string> all(std::begin(verbs::kVerbs), std::end(verbs::kVerbs));
  for (const auto right : rights::kRights) all.emplace(to_string(right));
  for (std::size_t kind = 0; kind < std::variant_size_v<model::Body>; ++kind)
    all.emplace(to_string(static_cast<model::MessageKind>(kind)));
  return all;
}

/// What members can ask an island for, and everything else that an ingenious client may try.
TEST_F(Commands, ReachNothingButPointsThatTheyName) {
  start(R"({"commands": ["**"]})");
  const std::size_t before = island.sets.size();
  for (const auto* topic : {"settings",
                            "settings/reload",
                            "inbox",
                            "inbox/knx/1",
                            "GATEWAY",
                            "knx",
                            "knx/line",
                            "knx/property/line",
                            "knx/1",
                            "knx/1/actuator",
                            "recorder/all",
                            "history",
                            "bridge/ha",
                            "devices",
                            "islands",
                            "log/lines",
                            "alerts",
                            "knx/1/actuator/none-1",
                            "inbox/a/b/c",
                            "settings/a/actuator/lamp-1",
                            "property/x/actuator/lamp-1",
                            "knx/+/actuator/lamp-1",
                            "GATEWAY/a/b/c"})
    send(std::string("rubicon/6541/") + topic + "/set", "reload");
  // In the places where a topic has a network, a device, a kind and a point.
  for (const auto& verb : all_verbs()) {
    for (const auto& topic :
         {"GATEWAY/1/" + verb + "/lamp-1", verb + "/1/actuator/lamp-1", "knx/" + verb + "/actuator/lamp-1",
          "knx/1/" + verb + "/lamp-1", "knx/1/actuator/" + verb})
      send("rubicon/6541/" + topic + "/set", R"({"do":")" + verb + R"("})");
  }
  for (const auto* topic : {"rubicon/77/knx/1/actuator/lamp-1/set", "rubicon/6541/knx/1/actuator/lamp-1/command"})
    send(topic, "on");
  EXPECT_EQ(island.sets.size(), before);
}

TEST_F(Commands, OfASirenMayHaveAToneAndALoudness) {
  island.network("knx");
  island.device("knx.2", "Siren",
                {{"actuator", "siren-1", "off"},
                 {"property", "melody-1", "fire", "good", {"burglar", "fire"}},
                 {"property", "duration-1", "60"},
                 {"property", "volume-1", "80"}});
  start(R"({"commands": ["proxy.knx.2.*.siren-*.command", "proxy.knx.2.property.melody-1.command",
                         "proxy.knx.2.property.volume-1.command"]})");
  const std::string siren = "rubicon/6541/knx/2/actuator/siren-1";
  const auto asked = [&] {
    std::vector<std::string> all;
    for (const auto& set : std::exchange(island.sets, {})) all.push_back(set.key.substr(12) + " " + set.value);
    return all;
  };
  send(siren + "/set", R"({"state":"on","tone":"burglar"})");
  EXPECT_THAT(asked(), ElementsAre("property.melody-1.command burglar", "actuator.siren-1.command on"));
  send(siren + "/set", R"({"state":"on","volume_level":0.55})");
  EXPECT_THAT(asked(), ElementsAre("property.volume-1.command 55", "actuator.siren-1.command on"))
      << "theirs is from 0 to 1";
  send(siren + "/set", R"({"state":"off"})");
  EXPECT_THAT(asked(), ElementsAre("actuator.siren-1.command off"));
  send(siren + "/set", "on");
  EXPECT_THAT(asked(), ElementsAre("actuator.siren-1.command on"));
  broker.forget_published();
  send(siren + "/set", R"({"state":"on","duration":10})");
  EXPECT_THAT(asked(), IsEmpty()) << "the patterns do not name the duration";
  EXPECT_EQ(outcome(siren), "refused");
}

TEST_F(Commands, OfNonsenseAreRefused) {
  start();
  send(kSet, std::string(1 << 20U, 'x'));
  EXPECT_EQ(outcome(kTopic), "refused");
  EXPECT_THAT(island.sets, IsEmpty());
  for (const auto* text : {"", "\xff\xfe", "{}", "\x01"}) send(kSet, text);
  EXPECT_LE(island.sets.size(), 4U) << "what the text means, the island decides";
  EXPECT_EQ(made->status().state, "up");
}

TEST_F(Commands, UnderWayAreBounded) {
  start();
  for (int i = 0; i < 1500; ++i) {
    broker.publish(kSet, "on");
    if (i % 100 == 0) time.run_for(10ms);
  }
  time.run_for(1s);
  EXPECT_EQ(island.sets.size(), 1000U);
  EXPECT_EQ(made->status().counters.at("commands-refused"), 500U);
}

TEST_F(Commands, WithoutAJudgeAreThoseOfTheComponent) {
  judge.reset();
  alone = true;
  start();
  send(kSet, "on");
  EXPECT_EQ(island.sets.size(), 1U);
  EXPECT_EQ(at("rubicon/bridge-ha/online"), "online");
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
