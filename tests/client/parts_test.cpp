#include <algorithm>

#include "client/client_parts.h"
#include "client/message_client.h"
#include "client/points.h"
#include "client/remote_set_tracker.h"

namespace rubicon::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_F(ClientParts, DevicesAreToldWhenTheyComeChangeAndGo) {
  std::vector<std::string> told;
  const DeviceWatch watch(self.space, {{}, "wsn*", "temperature", ""}, [&](const Device& device, bool present) {
    told.push_back(device.key() + " " + (present ? device.status : "gone"));
  });
  describe("7",
           R"({"name":"Kitchen","type":"EM1000","sensors":["temperature-1"],"actuators":[],"properties":["rate"]})");
  describe("8", R"({"name":"Hall","sensors":["light-1"]})");
  time.run_ready();
  EXPECT_THAT(told, ElementsAre("proxy.wsn-1.7 reachable"));
  told.clear();
  ASSERT_TRUE(island->space.set("proxy.wsn-1.7.status", R"({"status":"unreachable"})"));
  time.run_ready();
  ASSERT_TRUE(island->space.set("proxy.wsn-1.7.status", R"({"status":"unreachable","since":5})"));
  time.run_ready();
  island->space.erase({std::nullopt, "proxy.wsn-1.**"});
  time.run_ready();
  EXPECT_THAT(told, ElementsAre("proxy.wsn-1.7 unreachable", "proxy.wsn-1.7 gone"));
}

TEST(DeviceQuery, FitsByNetworkTypeAndName) {
  const auto device = device_from(OwnerId(1), "proxy.knx-hall.1_4_6.description",
                                  R"({"name":"Door","address":"1.4.6","type":"actuator","actuators":["switch-1"]})");
  ASSERT_TRUE(device);
  EXPECT_EQ(device->key(), "proxy.knx-hall.1_4_6");
  EXPECT_TRUE(fits({}, *device));
  EXPECT_TRUE(fits({OwnerId(1), "knx*", "switch", "Door"}, *device));
  EXPECT_TRUE(fits({{}, "", "", "1.4.6"}, *device));
  EXPECT_TRUE(fits({{}, "", "", "1_4_6"}, *device));
  EXPECT_FALSE(fits({OwnerId(2), "", "", ""}, *device));
  EXPECT_FALSE(fits({{}, "wsn*", "", ""}, *device));
  EXPECT_FALSE(fits({{}, "", "light", ""}, *device));
  EXPECT_FALSE(fits({{}, "", "illuminance", ""}, *device));
  const auto machine = device_from(OwnerId(1), "proxy.zigbee.7.description", R"({"actuators":["brew_strength-1"]})");
  ASSERT_TRUE(machine);
  EXPECT_TRUE(fits({{}, "", "brew_strength", ""}, *machine)) << "an open type";
  EXPECT_FALSE(device_from(OwnerId(1), "proxy.knx-hall.description", "{}"));
  EXPECT_FALSE(device_from(OwnerId(1), "proxy.knx-hall.1.description", "x"));
}

TEST(DeviceQuery, MayFitWithoutReadingTheJson) {
  const std::string key = "proxy.knx-hall.1_4_6.description";
  const std::string text = R"({"name":"Kücheninsel 7","area":"Küche","address":"1/4/6","sensors":["light-1"]})";
  const auto may = [&](const std::string& name, const std::string& area = {}) {
    return may_fit({{}, "", "", name, area}, key, text);
  };
  for (const auto* name : {"", "*", "Kücheninsel 7", "K?cheninsel*", "*insel 7", "1_4_6", "1/4/6", "1*6", "Kü*7"})
    EXPECT_TRUE(may(name)) << name;
  EXPECT_TRUE(may("*insel*", "K*che"));
  EXPECT_FALSE(may("*insel 8"));
  EXPECT_FALSE(may("Keller*"));
  EXPECT_FALSE(may("*insel*", "Keller"));
  EXPECT_TRUE(may_fit({{}, "", "", "Tür"}, key, R"({"name":"T\u00fcr"})")) << "letters may be written as numbers";
  EXPECT_TRUE(may_fit({{}, "", "", "a\"b"}, key, R"({"name":"a\"b"})"));
}

struct ClientCommands : ClientParts {
  void SetUp() override {
    ASSERT_TRUE(island->space.set("d.command", ""));
    ASSERT_TRUE(island->space.set("d.description", R"({"report":"event"})"));
    policy = island->space.add_policy({kIsland, "**"}, [this](const tuples::RemoteSet& request) {
      last = request;
      return request.value == "no" ? tuples::SetDecision::refused({ErrorCode::kOutOfRange, "not that"})
                                   : tuples::SetDecision::applied();
    });
  }
  void state(std::uint64_t request, const std::string& word) {
    ASSERT_TRUE(island->space.set("d.status", R"({"quality":"good","command":{"state":")" + word +
                                                  R"(","creator":70000,"request":)" + std::to_string(request) +
                                                  R"(,"reason":"because"}})"));
    time.run_for(1ms);
  }
  OutcomeCall end = [this](const Outcome& outcome) { ended.push_back(outcome.state + " " + outcome.reason); };
  tuples::Handle policy;
  tuples::RemoteSet last;
  std::vector<std::string> ended;
};

TEST_F(ClientCommands, AreFollowedToTheirFinalState) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  state(last.request, "queued");
  state(last.request + 1, "confirmed");  // somebody else's
  state(last.request, "sent");
  EXPECT_THAT(ended, IsEmpty());
  state(last.request, "confirmed");
  state(last.request, "superseded");
  EXPECT_THAT(ended, ElementsAre("confirmed because"));
}

TEST_F(ClientCommands, OfAStateWhoseOutcomeIsGoneEndUnknown) {
  ASSERT_TRUE(island->space.set("d.description", R"({"report":"state"})"));
  state(7, "confirmed");  // of somebody before
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, IsEmpty());
  state(last.request, "sent");
  state(last.request + 1, "queued");
  EXPECT_THAT(ended, ElementsAre("timed-out not known how it ended before the command of component 70000 came"));
}

/// It ended between two deliveries of the status, which shows the next command already.
TEST_F(ClientCommands, AreFoundAmongThoseThatEndedBefore) {
  ASSERT_TRUE(island->space.set("d.description", R"({"report":"state"})"));
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  ASSERT_TRUE(island->space.set(
      "d.status", R"({"quality":"good","command":{"state":"queued","creator":70001,"request":1},"ended":[)"
                  R"({"creator":70001,"request":)" +
                      std::to_string(last.request) + R"(,"state":"expired"},{"creator":70000,"request":)" +
                      std::to_string(last.request) + R"(,"state":"failed","reason":"no power"}]})"));
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("failed no power"));
}

TEST_F(ClientCommands, ThatAreRefusedSayWhy) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "no", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("refused not that"));
}

TEST_F(ClientCommands, EndWithWhatIsKnownWhenNothingMoreIsHeard) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, 2s, 3s);
  time.run_for(1ms);
  state(last.request, "queued");
  time.run_for(6s);
  EXPECT_THAT(ended, ElementsAre("timed-out no news of it since it was queued: because"));
}

TEST_F(ClientCommands, CarryTheDocumentedTimeToLiveIfTheirCommanderNamesNone) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_TRUE(last.time_to_live_given);
  EXPECT_GT(last.time_to_live, 4s);
  EXPECT_LE(last.time_to_live, 5s);
}

TEST_F(ClientCommands, AreWaitedForAsLongAsTheIslandSaysThatTheyMayTake) {
  std::vector<std::string> under_way;
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, 1s, 3s, [&](const Outcome& outcome) {
    under_way.push_back(outcome.state + " " + outcome.reason + " " +
                        std::to_string(outcome.until.time_since_epoch().count()));
  });
  time.run_for(1ms);
  const auto say = [&](const std::string& word, const std::string& waiting) {
    ASSERT_TRUE(island->space.set("d.status", R"({"command":{"state":")" + word + R"(","creator":70000,"request":)" +
                                                  std::to_string(last.request) + waiting + R"(,"reason":"asleep"}})"));
    time.run_for(1ms);
  };
  say("queued", R"(,"since":100,"until":160.5)");
  EXPECT_THAT(under_way, ElementsAre("queued asleep 160500000"));
  time.run_for(62s);
  EXPECT_THAT(ended, IsEmpty());
  say("expired", R"(,"since":160.5)");
  EXPECT_THAT(ended, ElementsAre("expired asleep"));
}

TEST_F(ClientCommands, OfADeviceThatLeavesFail) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  state(last.request, "queued");
  ASSERT_TRUE(island->space.erase("d.status"));
  time.run_for(5s);
  EXPECT_THAT(ended, ElementsAre("failed the device left"));
}

TEST_F(ClientCommands, AreFollowedToAnotherIsland) {
  Member other(ecology, time, 2);
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  state(last.request, "queued");
  ASSERT_TRUE(island->space.erase("d.status"));
  time.run_for(500ms);
  const auto says = [&](const std::string& word) {
    ASSERT_TRUE(other.space.set("d.status", R"({"command":{"state":")" + word + R"(","creator":70000,"request":)" +
                                                std::to_string(last.request) + "}}"));
    time.run_for(1ms);
  };
  says("queued");
  time.run_for(5s);
  EXPECT_THAT(ended, IsEmpty());
  says("confirmed");
  EXPECT_THAT(ended, ElementsAre("confirmed "));
}

TEST_F(ClientCommands, ToATupleThatIsOnlyCalledCommandEndWithTheAnswer) {
  const RemoteSetTracker tracker(time, self.space, kIsland, "command", "x", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("applied "));
}

TEST_F(ClientCommands, ToAPointThatItsOwnerDoesNotDescribeEndWithTheReply) {
  ASSERT_TRUE(island->space.set("robot.arm.status", R"({"pose":"home"})"));
  const RemoteSetTracker tracker(time, self.space, kIsland, "robot.arm.command", "x", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("applied "));
}

TEST_F(ClientCommands, ToAnOwnPointThatIsNotDescribedEndWithTheReply) {
  ASSERT_TRUE(self.space.set("robot.arm.command", ""));
  const auto own = self.space.add_policy({self.space.self(), "robot.**"},
                                         [](const auto&) { return tuples::SetDecision::applied(); });
  const RemoteSetTracker tracker(time, self.space, self.space.self(), "robot.arm.command", "x", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("applied "));
}

TEST_F(ClientCommands, ToTheIslandItselfAreFollowed) {
  const RemoteSetTracker tracker(time, self.space, kIsland, "proxy.settings.command", "try", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, IsEmpty());
  ASSERT_TRUE(island->space.set("proxy.settings.status", R"({"command":{"state":"refused","creator":70000,"request":)" +
                                                             std::to_string(last.request) + R"(,"reason":"line 3"}})"));
  time.run_for(1ms);
  EXPECT_THAT(ended, ElementsAre("refused line 3"));
}

TEST_F(ClientCommands, ToOtherTuplesEndWithTheAnswer) {
  const RemoteSetTracker errand(time, self.space, kIsland, "note", "x", end, {}, 15s);
  const RemoteSetTracker nobody(time, self.space, OwnerId(9), "note", "x", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, testing::UnorderedElementsAre("applied ", testing::StartsWith("no-such-owner")));
}

TEST_F(ClientCommands, SurviveStatusesThatAreNone) {
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, 1s, 1s);
  time.run_for(1ms);
  for (const auto* text : {"[]", "{", "{}", R"({"command":[]})", R"({"command":{"creator":"x","request":-1}})",
                           R"({"command":{"creator":70000,"request":1.5,"state":7}})"}) {
    ASSERT_TRUE(island->space.set("d.status", text));
    time.run_for(1ms);
  }
  EXPECT_THAT(ended, IsEmpty());
}

struct Messages : ClientParts {
  base::NullLogSink log;
  MessageClient there{time, island->space, log};
  MessageClient here{time, self.space, log};
  std::vector<std::string> heard, sent;
  SentCall note = [this](const std::string& why_not) { sent.push_back(why_not); };
};

TEST_F(Messages, ArriveOnceInOrderAndTheSenderHearsIt) {
  const auto some = there.on_message("note", [&](const UserMessage& message) {
    heard.push_back(std::to_string(number(message.from)) + " " + message.type + " " + message.bytes);
  });
  for (int i = 0; i < 3; ++i) here.send(kIsland, "note", std::to_string(i), note);
  time.run_for(1s);
  EXPECT_THAT(heard, ElementsAre("70000 note 0", "70000 note 1", "70000 note 2"));
  EXPECT_THAT(sent, ElementsAre("", "", ""));
}

TEST_F(Messages, ThatNobodyHearsOrTakesAreReported) {
  here.send(kIsland, "note", "x", note);
  here.send(OwnerId(5), "note", "x", note);
  time.run_for(1s);
  EXPECT_THAT(sent, testing::UnorderedElementsAre(testing::HasSubstr("island 1 has no listener"),
                                                  testing::HasSubstr("no component 5")));
}

TEST_F(Messages, ToOneselfAreMessagesToo) {
  here.send(OwnerId(70000), "note", "x", note);
  time.run_for(1s);
  EXPECT_THAT(sent, ElementsAre(testing::HasSubstr("island 70000 has no listener")));
  const auto some = here.on_message("note", [&](const UserMessage& message) { heard.push_back(message.bytes); });
  here.send(OwnerId(70000), "note", "y", note);
  time.run_for(1s);
  EXPECT_THAT(heard, ElementsAre("y"));
  EXPECT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent.back(), "");
}

TEST_F(Messages, BeyondTheBoundAreRefusedAndAllAreAnswered) {
  const auto all = there.on_message("note", [](const UserMessage&) {});
  constexpr int kMany = 10'500;
  for (int i = 0; i < kMany; ++i) here.send(kIsland, "note", "x", note);
  time.run_for(20s);
  EXPECT_EQ(sent.size(), static_cast<std::size_t>(kMany));
  EXPECT_GE(std::count_if(sent.begin(), sent.end(), [](const auto& why) { return why.starts_with("busy"); }), 500);
}

TEST_F(Messages, OfAllTypesCanBeHeard) {
  const auto all = there.on_message("", [&](const UserMessage& message) { heard.push_back(message.type); });
  here.send(kIsland, "a", "x", {});
  here.send(kIsland, "b", "x", {});
  time.run_for(1s);
  EXPECT_THAT(heard, ElementsAre("a", "b"));
}

TEST(DeviceQuery, FormerTypesFindThoseOfTodayAndTheOtherWayRound) {
  const auto now = device_from(OwnerId(1), "proxy.knx.sill.description", R"({"sensors":["light-1"]})");
  const auto before = device_from(OwnerId(1), "proxy.knx.sill.description", R"({"sensors":["illuminance-1"]})");
  ASSERT_TRUE(now && before);
  for (const auto* type : {"light", "illuminance"}) {
    EXPECT_TRUE(fits({{}, "", type, ""}, *now)) << type;
    EXPECT_TRUE(fits({{}, "", type, ""}, *before)) << type;
  }
  EXPECT_FALSE(fits({{}, "", "motion", ""}, *now));
}

}  // namespace
}  // namespace rubicon::client
