#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/virtual_scheduler.h"
#include "client/device_watch.h"
#include "client/message_client.h"
#include "client/remote_set_tracker.h"
#include "client/tuple_query.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::client {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

struct Member {
  Member(tuples::MemoryEcology& ecology, VirtualScheduler& scheduler, std::uint32_t id)
      : link(std::move(*ecology.join(OwnerId(id)))), space(OwnerId(id), scheduler, *link) {}
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
};

/// An island (1) played by hand and a component (70000), in virtual time.
struct ClientParts : testing::Test {
  static constexpr OwnerId kIsland{1};

  void describe(const std::string& device, const std::string& rest) {
    ASSERT_TRUE(island->space.set("proxy.wsn-1." + device + ".description", rest, {"application/json"}));
    ASSERT_TRUE(island->space.set("proxy.wsn-1." + device + ".status", R"({"status":"reachable"})"));
  }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<Member> island = std::make_unique<Member>(ecology, time, 1);
  Member self{ecology, time, 70000};
  PeerDiscovery peer_discovery{time, self.space, kDdsPace};
  std::vector<Tuple> found;
  int times = 0;
  TuplesCall keep = [this](std::vector<Tuple> tuples) {
    found = std::move(tuples);
    ++times;
  };
};

TEST_F(ClientParts, AReadingEndsWhenAllIsHere) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(island->space.set("a.t" + std::to_string(i), "x"));
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a.*"}, keep, 3s);
  time.run_for(kDdsPace.quiet - 1ms);
  EXPECT_EQ(times, 0) << "somebody may still come";
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 3U);
  time.run_for(10s);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(self.space.stats().subscriptions, 0U);
}

TEST_F(ClientParts, OnPeisAReadingWaitsUntilKernelsHadTimeToAppear) {
  PeerDiscovery search{time, self.space, kPeisPace};
  ASSERT_TRUE(island->space.set("a", "x"));
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kPeisPace.search - 1ms);
  EXPECT_EQ(times, 0) << "a kernel announces itself each second";
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
}

/// As with trust, where the first component of a process may come long before the next one.
TEST_F(ClientParts, AReadingWaitsForComponentsThatAreOnTheirWay) {
  bool expected = true;
  PeerDiscovery search{time, self.space, kTrustPace, [&] { return expected; }};
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kTrustPace.named_owner - 100ms);
  EXPECT_EQ(times, 0);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(1ms);
  expected = false;
  time.run_for(kTrustPace.quiet + 21ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
}

TEST_F(ClientParts, AReadingDoesNotWaitForeverForThem) {
  PeerDiscovery search{time, self.space, kTrustPace, [] { return true; }};
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kTrustPace.named_owner - 1ms);
  EXPECT_EQ(times, 0);
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
}

/// A stop of this process may end the lease of a component that it has just met.
TEST_F(ClientParts, AReadingWaitsForTheComponentThatWasLost) {
  ASSERT_TRUE(island->space.set("a", "x"));
  time.run_for(100ms);
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 10s);
  ecology.cut(OwnerId(1), OwnerId(70000));
  time.run_for(3900ms);
  EXPECT_EQ(times, 0);
  ASSERT_TRUE(island->space.set("a", "again"));
  ecology.mend(OwnerId(1), OwnerId(70000));
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_EQ(times, 1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].value, "again");
}

TEST_F(ClientParts, AStopWhileALostComponentIsAwaitedUsesUpNoPatience) {
  time.run_for(100ms);
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 10s);
  ecology.cut(OwnerId(1), OwnerId(70000));
  time.run_for(2s);
  time.stop_for(20s);
  time.run_for(100ms);
  EXPECT_EQ(times, 0);
  time.run_for(2s);
  EXPECT_EQ(times, 1);
}

/// As in a virtual machine that gets no processor for a while: what others sent meanwhile is taken afterwards.
TEST_F(ClientParts, AStopOfThisProcessIsNoTimeInWhichNobodyCame) {
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s);
  time.run_for(100ms);
  time.stop_for(20s);
  time.run_for(100ms);
  EXPECT_EQ(times, 0);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
}

TEST_F(ClientParts, AStopBeforeAReadingIsNone) {
  time.stop_for(20s);
  EXPECT_FALSE(peer_discovery.complete({}));
  EXPECT_FALSE(peer_discovery.complete(OwnerId(7)));
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_TRUE(peer_discovery.complete({}));
  EXPECT_FALSE(peer_discovery.complete(OwnerId(7)));
  time.run_for(kDdsPace.named_owner);
  EXPECT_TRUE(peer_discovery.complete(OwnerId(7)));
  time.stop_for(20s);
  EXPECT_TRUE(peer_discovery.complete(OwnerId(7)));
}

/// Is present and answers nothing.
struct Mute final : tuples::LinkListener {
  void on_changes(OwnerId, std::span<const tuples::Change>) override {}
  void on_subscribe(OwnerId, const tuples::SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const tuples::RemoteSet&) override {}
  bool on_reply(OwnerId, const tuples::Reply&) override { return true; }
  void on_peer(const tuples::PeerIdentity&, tuples::PeerEvent) override {}
  void on_summary(OwnerId, std::string_view) override {}
};

TEST_F(ClientParts, AReadingEndsWithoutThoseWhoDoNotAnswerAndSaysSo) {
  ASSERT_TRUE(island->space.set("a", "x"));
  Mute mute;
  const auto link = std::move(*ecology.join(OwnerId(2)));
  link->attach(mute, 1);
  std::vector<OwnerId> left_out;
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s,
                         [&](const std::vector<OwnerId>& owners) { left_out = owners; });
  time.run_for(1s);
  time.stop_for(20s);
  time.run_for(1800ms);
  EXPECT_EQ(times, 0) << "a stop of this process is a moment of the patience";
  time.run_for(300ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
  EXPECT_THAT(left_out, ElementsAre(OwnerId(2)));
}

TEST_F(ClientParts, AReadingOfOneOwnerWaitsForNobodyElse) {
  ASSERT_TRUE(island->space.set("a", "x"));
  time.run_ready();
  const TupleQuery query(time, self.space, peer_discovery, {kIsland, "a"}, keep, 3s);
  time.run_for(1ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].value, "x");
}

TEST_F(ClientParts, AReadingOfAnOwnerThatIsNotThereEndsEmpty) {
  const TupleQuery query(time, self.space, peer_discovery, {OwnerId(7), "a"}, keep, 3s);
  time.run_for(kDdsPace.named_owner + 1ms);
  EXPECT_EQ(times, 1);
  EXPECT_THAT(found, IsEmpty());
}

TEST_F(ClientParts, AReadingCreatesNoDemand) {
  std::vector<std::string> wanted;
  ASSERT_TRUE(island->space.set("a", "x"));
  const auto watch = island->space.watch_demand({std::nullopt, "**"}, [&](const tuples::Demand& demand) {
    if (demand.wanted) wanted.emplace_back(demand.key);
  });
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "**"}, keep, 3s);
  time.run_for(5s);
  EXPECT_EQ(found.size(), 1U);
  EXPECT_THAT(wanted, IsEmpty());
}

TEST_F(ClientParts, ANewcomerDuringTheReadingIsWaitedFor) {
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s);
  time.run_for(200ms);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(200ms);
  EXPECT_EQ(times, 0);
  time.run_for(101ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].owner, OwnerId(2));
}

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

TEST_F(ClientCommands, OfAStateAreSupersededByAnothersCommandThatIsSeenAlone) {
  ASSERT_TRUE(island->space.set("d.description", R"({"report":"state"})"));
  state(7, "confirmed");  // of somebody before
  const RemoteSetTracker errand(time, self.space, kIsland, "d.command", "on", end, {}, 15s);
  time.run_for(1ms);
  EXPECT_THAT(ended, IsEmpty());
  state(last.request, "sent");
  state(last.request + 1, "queued");
  EXPECT_THAT(ended, ElementsAre("superseded by component 70000"));
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
