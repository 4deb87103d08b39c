#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "tuples/component.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// Gives each member what its test says, by the first part of the key, and writes down what it is asked.
struct ListJudge final : Judge {
  Access access(const Member& who, std::string_view key) const override {
    ++asked;
    const auto found = rights.find({who.name, std::string(key.substr(0, key.find('.')))});
    return found == rights.end() ? Access{false, false, {}} : found->second;
  }
  bool sees_all(const Member& who) const override { return who.name == "admin"; }
  Result<void> may_set(const Member& who, const RemoteSet& set) const override {
    keys_asked += set.key.size();
    if (who.name == "admin") return {};
    return fail(ErrorCode::kRefused, who.name + " may not set " + set.key);
  }
  Result<void> may_send(const Member& who, std::string_view where) const override {
    return fail(ErrorCode::kRefused, who.name + " may not send to " + std::string(where));
  }
  Result<void> may_by_names(const Member&, Act, std::span<const std::string>) const override {
    return fail(ErrorCode::kRefused, "no");
  }
  Handle speak_for(const Member&, OwnerId, std::uint64_t) override { return {}; }
  const Member* spoken_for(OwnerId, std::uint64_t) const override { return nullptr; }
  void record(const Member&, const OtherRequest&, const Result<void>&) override {}
  void answered(const Member& who, std::string_view host, const RemoteSet& set, const Reply& reply) override {
    answers.push_back(who.name + "@" + std::string(host) + " " + set.key + " " + std::string(to_string(reply.verdict)));
    reasons.push_back(reply.text);
  }

  std::map<std::pair<std::string, std::string>, Access> rights;
  mutable int asked = 0;
  mutable std::size_t keys_asked = 0;  ///< their bytes, of sets
  std::vector<std::string> answers, reasons;
};

constexpr Access kSees{true, false, {}};
constexpr Access kWakes{true, true, {}};

/// An island (1) with a judge, a robot (70000), a panel (70001) and a console of the island's process (70002).
struct RightsOfPeers : testing::Test {
  static constexpr OwnerId kIsland{1};

  RightsOfPeers() {
    ecology.judge(kIsland, judge);
    ecology.certify(OwnerId(70000), {.name = "robot", .ids = {{70000, 70000}}});
    ecology.certify(OwnerId(70001), {.name = "panel", .ids = {{70001, 70001}}});
  }
  void SetUp() override {
    island = join(1);
    robot = join(70000);
    panel = join(70001);
    for (const auto* key : {"hall.light", "lab.light", "attic.light"}) ASSERT_TRUE(island->space.set(key, "1"));
    watch = island->space.watch_demand(pattern("**"), [this](const Demand& demand) {
      demands.push_back(std::string(demand.key) + (demand.wanted ? " on " : " off ") +
                        std::to_string(demand.interval / 1ms));
    });
    turn();
  }
  struct Joined {
    Joined(MemoryEcology& ecology, VirtualScheduler& time, OwnerId id)
        : link(std::move(*ecology.join(id))), space(id, time, *link) {}
    std::unique_ptr<Link> link;
    TupleSpace space;
  };
  std::unique_ptr<Joined> join(std::uint32_t id) { return std::make_unique<Joined>(ecology, time, OwnerId(id)); }
  void turn() { time.run_for(1ms); }
  Handle subscribe(Joined& who, Listener& listener, const Flow& flow = {}, std::string_view keys = "**") {
    return who.space.subscribe({kIsland, std::string(keys)}, flow, listener.call());
  }
  Seen take_demands() { return std::exchange(demands, {}); }
  Reply set(Joined& who, std::string_view key) {
    Reply answer;
    who.space.set_remote(kIsland, key, "2", 60s, [&](const Reply& reply) { answer = reply; });
    turn();
    return answer;
  }

  VirtualScheduler time;
  MemoryEcology ecology{time};
  std::shared_ptr<ListJudge> judge = std::make_shared<ListJudge>();
  std::unique_ptr<Joined> island, robot, panel;
  Handle watch;
  Seen demands;
  Listener by_robot, by_panel;
};

TEST_F(RightsOfPeers, TwoNamesSeeWhatEachMaySeeWithTheSamePattern) {
  judge->rights = {{{"robot", "hall"}, kWakes}, {{"robot", "lab"}, kWakes}, {{"panel", "attic"}, kWakes}};
  const auto one = subscribe(*robot, by_robot), other = subscribe(*panel, by_panel);
  turn();
  EXPECT_THAT(by_robot.take(), UnorderedElementsAre("hall.light=1", "lab.light=1"));
  EXPECT_THAT(by_panel.take(), UnorderedElementsAre("attic.light=1"));
  for (const auto* key : {"hall.light", "lab.light", "attic.light", "hall.new"})
    ASSERT_TRUE(island->space.set(key, "2"));
  turn();
  EXPECT_THAT(by_robot.take(), UnorderedElementsAre("hall.light=2", "lab.light=2", "hall.new=2"));
  EXPECT_THAT(by_panel.take(), UnorderedElementsAre("attic.light=2"));
}

TEST_F(RightsOfPeers, TheSnapshotEndsAlsoWithoutAnyTuple) {
  std::vector<OwnerId> ends;
  const auto handle =
      robot->space.subscribe({kIsland, "**"}, {}, by_robot.call(), [&](OwnerId o) { ends.push_back(o); });
  turn();
  EXPECT_THAT(by_robot.take(), IsEmpty());
  EXPECT_THAT(ends, ElementsAre(kIsland));
}

TEST_F(RightsOfPeers, AreAskedOncePerTupleAndSubscriptionAndNeverPerPublication) {
  judge->rights = {{{"robot", "hall"}, kWakes}, {{"robot", "lab"}, kSees}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  EXPECT_EQ(judge->asked, 3);
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(island->space.set("hall.light", std::to_string(i)));
    ASSERT_TRUE(island->space.set("attic.light", std::to_string(i)));
    turn();
  }
  EXPECT_EQ(judge->asked, 3);
  ASSERT_TRUE(island->space.set("hall.new", "1"));
  turn();
  EXPECT_EQ(judge->asked, 4);
}

TEST_F(RightsOfPeers, WithoutDemandNothingWakes) {
  judge->rights = {{{"robot", "hall"}, kSees}, {{"robot", "lab"}, kWakes}};
  auto handle = subscribe(*robot, by_robot);
  turn();
  EXPECT_THAT(by_robot.take(), UnorderedElementsAre("hall.light=1", "lab.light=1"));
  EXPECT_THAT(take_demands(), ElementsAre("lab.light on 0"));
  ASSERT_TRUE(island->space.set("hall.new", "1"));
  turn();
  EXPECT_THAT(take_demands(), IsEmpty());
  handle.reset();
  turn();
  EXPECT_THAT(take_demands(), ElementsAre("lab.light off 0"));
  EXPECT_FALSE(island->space.has_subscriber(*island->space.find("hall.light")));
}

TEST_F(RightsOfPeers, TheFastestIntervalClampsDemandAndDelivery) {
  judge->rights = {{{"robot", "hall"}, {true, true, 10s}}, {{"robot", "lab"}, {true, true, 2s}}};
  auto handle = subscribe(*robot, by_robot, {.minimum = 5s});
  turn();
  EXPECT_THAT(take_demands(), UnorderedElementsAre("hall.light on 10000", "lab.light on 5000"));
  by_robot.take();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(island->space.set("hall.light", std::to_string(i)));
    ASSERT_TRUE(island->space.set("lab.light", std::to_string(i)));
    time.run_for(1s);
  }
  const auto seen = by_robot.take();
  const auto of = [&](std::string_view key) {
    return std::count_if(seen.begin(), seen.end(), [&](const auto& one) { return one.starts_with(key); });
  };
  EXPECT_EQ(of("hall"), 2);
  EXPECT_EQ(of("lab"), 4);
  handle.reset();
  turn();
  EXPECT_THAT(take_demands(), UnorderedElementsAre("hall.light off 0", "lab.light off 0"));
}

TEST_F(RightsOfPeers, ADeadBandHoldsAlsoWithLessDemand) {
  judge->rights = {{{"robot", "hall"}, kSees}};
  const auto handle = subscribe(*robot, by_robot, {.dead_band = 5});
  turn();
  by_robot.take();
  for (const auto* value : {"2", "5", "7", "8"}) {
    ASSERT_TRUE(island->space.set("hall.light", value));
    turn();
  }
  EXPECT_THAT(by_robot.take(), ElementsAre("hall.light=7"));
}

TEST_F(RightsOfPeers, WhoSeesAllIsNotAskedPerTuple) {
  ecology.certify(OwnerId(70005), {.name = "admin", .ids = {{70005, 70005}}});
  const auto admin = join(70005), console = join(70006);
  Listener by_admin, by_console;
  const auto one = subscribe(*admin, by_admin), other = subscribe(*console, by_console);
  turn();
  EXPECT_EQ(by_admin.take().size(), 3U);
  EXPECT_EQ(by_console.take().size(), 3U) << "components of the own process may do everything";
  EXPECT_EQ(judge->asked, 0);
}

TEST_F(RightsOfPeers, AReloadTakesTuplesAwayAndGivesNewOnes) {
  judge->rights = {{{"robot", "hall"}, kWakes}, {{"robot", "lab"}, kWakes}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  by_robot.take();
  take_demands();
  judge->rights = {{{"robot", "lab"}, kSees}, {{"robot", "attic"}, {true, true, 3s}}};
  SpaceRights::rejudge(island->space);
  turn();
  EXPECT_THAT(take_demands(), UnorderedElementsAre("hall.light off 0", "lab.light off 0", "attic.light on 3000"));
  EXPECT_FALSE(robot->space.get(kIsland, "hall.light"));
  EXPECT_TRUE(robot->space.get(kIsland, "lab.light"));
  EXPECT_THAT(by_robot.take(), testing::IsSupersetOf({"hall.light deleted", "attic.light=1"}));
  for (const auto* key : {"hall.light", "lab.light", "attic.light"}) ASSERT_TRUE(island->space.set(key, "2"));
  time.run_for(4s);
  EXPECT_THAT(by_robot.take(), UnorderedElementsAre("lab.light=2", "attic.light=2"));
  judge->rights = {{{"robot", "hall"}, kWakes}};
  SpaceRights::rejudge(island->space);
  turn();
  EXPECT_THAT(by_robot.take(), UnorderedElementsAre("lab.light deleted", "attic.light deleted", "hall.light=2"));
}

TEST_F(RightsOfPeers, AReloadThatChangesNothingSendsNothing) {
  judge->rights = {{{"robot", "hall"}, kSees}, {{"robot", "lab"}, {true, true, 3s}}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  by_robot.take();
  SpaceRights::rejudge(island->space);
  EXPECT_EQ(island->space.stats().queued, 0U);
  turn();
  EXPECT_THAT(by_robot.take(), IsEmpty());
}

TEST_F(RightsOfPeers, WhatIsTakenAwayIsNotSentAnyMore) {
  judge->rights = {{{"robot", "hall"}, kWakes}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  by_robot.take();
  ASSERT_TRUE(island->space.set("hall.light", "secret"));
  judge->rights.clear();
  SpaceRights::rejudge(island->space);
  turn();
  EXPECT_THAT(by_robot.take(), ElementsAre("hall.light deleted"));
}

TEST_F(RightsOfPeers, ASetIsRefusedByNameAndEachAnswerIsReported) {
  const auto policy =
      island->space.add_policy(pattern("hall.light"), [](const RemoteSet&) { return SetDecision::applied(); });
  ecology.certify(OwnerId(70005), {.name = "admin", .ids = {{70005, 70005}}});
  const auto admin = join(70005), console = join(70006);
  turn();
  EXPECT_EQ(set(*robot, "hall.light").text, "robot may not set hall.light");
  EXPECT_EQ(set(*admin, "hall.light").verdict, Verdict::kApplied);
  EXPECT_EQ(set(*admin, "lab.light").verdict, Verdict::kRefused);
  EXPECT_EQ(set(*console, "hall.light").verdict, Verdict::kApplied);
  EXPECT_THAT(judge->answers, ElementsAre("robot@memory hall.light refused", "admin@memory hall.light applied",
                                          "admin@memory lab.light refused"));
}

/// One without any right could fill the audit by it.
TEST_F(RightsOfPeers, AKeyThatIsNoneIsRefusedBeforeItsRightsAndReportedInShort) {
  const auto answer = set(*robot, std::string(1'000'000, 'x'));
  EXPECT_EQ(answer.code, ErrorCode::kInvalid);
  EXPECT_LT(answer.text.size(), 200U);
  EXPECT_EQ(judge->keys_asked, 0U);
  EXPECT_THAT(judge->answers, ElementsAre("robot@memory " + std::string(255, 'x') + " refused"));
  EXPECT_THAT(judge->reasons, ElementsAre(answer.text));
}

TEST_F(RightsOfPeers, WhoAComponentIsIsKnownWhileItIsUp) {
  EXPECT_EQ(SpaceRights::member_of(island->space, OwnerId(70000))->name, "robot");
  EXPECT_EQ(SpaceRights::policy(island->space).may_send(OwnerId(70000), "own").error().text,
            "robot may not send to own");
  robot.reset();
  turn();
  EXPECT_EQ(SpaceRights::member_of(island->space, OwnerId(70000)), nullptr);
  EXPECT_FALSE(SpaceRights::policy(island->space).may_send(OwnerId(70000), "own"));
}

TEST_F(RightsOfPeers, ManyTuplesAreJudgedAgainOverSeveralTurns) {
  for (int i = 0; i < 50'000; ++i) ASSERT_TRUE(island->space.set("hall.n" + std::to_string(i), "1"));
  judge->rights = {{{"robot", "hall"}, kWakes}};
  const auto handle = subscribe(*robot, by_robot);
  time.run_for(1s);
  EXPECT_EQ(by_robot.take().size(), 50'001U);
  judge->rights.clear();
  SpaceRights::rejudge(island->space);
  time.run_for(1s);
  EXPECT_EQ(by_robot.take().size(), 50'001U);
  EXPECT_EQ(robot->space.stats().cached, 0U);
}

TEST_F(RightsOfPeers, WhatFindsNoRoomInAFullQueueIsTakenAwayAllTheSame) {
  for (const auto* key : {"lab.a", "lab.b", "lab.c", "lab.d"}) ASSERT_TRUE(island->space.set(key, "1"));
  judge->rights = {{{"robot", "hall"}, kWakes}, {{"robot", "lab"}, kWakes}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  by_robot.take();
  SpaceRights::limit_queues(island->space, 3);
  for (const auto* key : {"lab.a", "lab.b", "lab.c"}) ASSERT_TRUE(island->space.set(key, "secret"));
  judge->rights = {{{"robot", "hall"}, kWakes}};
  SpaceRights::rejudge(island->space);
  time.run_for(1s);
  for (const auto* key : {"lab.light", "lab.a", "lab.b", "lab.c", "lab.d"})
    EXPECT_FALSE(robot->space.get(kIsland, key)) << key;
  EXPECT_TRUE(robot->space.get(kIsland, "hall.light"));
  EXPECT_THAT(by_robot.take(), testing::Each(testing::HasSubstr("deleted")));
  ASSERT_TRUE(island->space.set("hall.light", "2"));
  turn();
  EXPECT_THAT(by_robot.take(), ElementsAre("hall.light=2"));
}

TEST_F(RightsOfPeers, OfTwoSubscriptionsNeitherSendsWhatTheOtherLost) {
  for (int i = 0; i < 60'000; ++i) ASSERT_TRUE(island->space.set("attic.n" + std::to_string(i), "1"));
  judge->rights = {{{"robot", "hall"}, kWakes}};
  const auto one = subscribe(*robot, by_robot), other = subscribe(*robot, by_robot);
  time.run_for(1s);
  by_robot.take();
  judge->rights.clear();
  SpaceRights::rejudge(island->space);
  // The tuples of the attic, which nobody sees, take several turns; meanwhile the light is set in each of them.
  std::function<void(int)> publish = [&](int left) {
    EXPECT_TRUE(island->space.set("hall.light", "secret"));
    if (left > 0) time.post([&publish, left] { publish(left - 1); });
  };
  time.post([&] { publish(30); });
  time.run_for(1s);
  const auto seen = by_robot.take();
  const auto end = std::find(seen.begin(), seen.end(), "hall.light deleted");
  ASSERT_NE(end, seen.end());
  EXPECT_EQ(std::find(end, seen.end(), "hall.light=secret"), seen.end());
  EXPECT_EQ(robot->space.stats().cached, 0U);
}

TEST_F(RightsOfPeers, ReloadsLeaveNoSubscriptionsBehind) {
  judge->rights = {{{"robot", "hall"}, {true, true, 1s}}};
  const auto handle = subscribe(*robot, by_robot);
  turn();
  const auto before = island->space.stats().subscriptions;
  for (int i = 2; i < 50; ++i) {
    judge->rights = {{{"robot", "hall"}, {true, true, 1s * i}}};
    SpaceRights::rejudge(island->space);
    turn();
  }
  EXPECT_EQ(island->space.stats().subscriptions, before);
  time.run_for(60s);
  by_robot.take();
  ASSERT_TRUE(island->space.set("hall.light", "2"));
  turn();
  EXPECT_THAT(by_robot.take(), ElementsAre("hall.light=2"));
  judge->rights.clear();
  SpaceRights::rejudge(island->space);
  turn();
  EXPECT_THAT(by_robot.take(), ElementsAre("hall.light deleted"));
}

TEST_F(RightsOfPeers, ReloadsThatMeetWhileTuplesAreJudgedTakeAllAway) {
  for (int i = 0; i < 50'000; ++i) ASSERT_TRUE(island->space.set("hall.n" + std::to_string(i), "1"));
  judge->rights = {{{"robot", "hall"}, {true, true, 1s}}};
  const auto handle = subscribe(*robot, by_robot);
  time.run_for(1s);
  for (int i = 2; i < 5; ++i) {
    judge->rights = {{{"robot", "hall"}, {true, true, 1s * i}}};
    SpaceRights::rejudge(island->space);
  }
  time.run_for(10s);
  const auto subscriptions = island->space.stats().subscriptions;
  judge->rights.clear();
  SpaceRights::rejudge(island->space);
  time.run_for(1s);
  EXPECT_EQ(island->space.stats().subscriptions, subscriptions - 1);
  EXPECT_EQ(robot->space.stats().cached, 0U);
}

}  // namespace
}  // namespace rubicon::tuples
