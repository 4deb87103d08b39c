#include "tuples/host/connection.h"
#include "tuples/host/host_programs.h"

namespace rubicon::tuples::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(HostEcologyInMemory, ANewcomerKnowsAllThatIsThereInTheTurnsOfOneInstant) {
  auto island = begin();
  auto& home = island->start(kIsland);
  ASSERT_TRUE(home.set("lamp", "on"));
  time.run_ready();
  auto tool = begin();
  auto& space = tool->start(kTool);
  EXPECT_FALSE(tool->ecology->knows_all());
  const auto all = read_all(space);
  time.run_ready();
  EXPECT_TRUE(tool->ecology->knows_all());
  EXPECT_THAT(space.peers(), ElementsAre(kIsland));
  EXPECT_EQ(value(space, kIsland, "lamp"), "on");
  EXPECT_THAT(home.peers(), ElementsAre(kTool));
}

TEST_F(HostEcologyInMemory, ComponentsOfOneProcessMeetAndAreOfTheOwnProcess) {
  auto both = begin();
  auto& home = both->start(kIsland);
  auto& space = both->start(kTool);
  const auto all = read_all(space);
  ASSERT_TRUE(home.set("lamp", "on"));
  time.run_ready();
  EXPECT_EQ(value(space, kIsland, "lamp"), "on");
  EXPECT_THAT(both->take(), testing::UnorderedElementsAre("6541 met 70001", "70001 met 6541"));
}

TEST_F(HostEcologyInMemory, WhoEndsLeavesAndWhoIsKilledIsLostAtOnceByEachOther) {
  auto island = begin();
  island->start(kIsland);
  auto tool = begin(), other = begin();
  tool->start(kTool);
  other->start(kOther);
  time.run_ready();
  for (auto* one : {island.get(), tool.get(), other.get()}) one->take();
  tool->watches.clear();
  tool->members.clear();
  tool.reset();
  time.run_ready();
  EXPECT_THAT(island->take(), ElementsAre("6541 saw leave 70001"));
  EXPECT_THAT(other->take(), ElementsAre("70002 saw leave 70001"));
  host.kill(island->number);
  time.run_ready();
  EXPECT_THAT(other->take(), ElementsAre("70002 lost 6541"));
}

TEST_F(HostEcologyInMemory, TwoThatComeAtOnceHaveOneConnectionAndNobodyIsLostForAMoment) {
  for (const bool shrink : {false, true}) {
    host.tokens_shrink = shrink;
    std::vector<std::unique_ptr<Program>> all;
    for (std::uint32_t i = 0; i < 5; ++i) {
      all.push_back(begin());
      all.back()->start(OwnerId(70000 + i));
    }
    time.run_for(1s);
    for (auto& one : all) {
      EXPECT_EQ(one->members.begin()->second->space.peers().size(), 4U);
      EXPECT_THAT(one->take(), testing::Each(HasSubstr(" met ")));
      EXPECT_TRUE(one->ecology->knows_all());
      EXPECT_TRUE(one->log.lines.empty());
    }
    // Each of them is gone with one end of one connection.
    all.pop_back();
    time.run_ready();
    for (auto& one : all) EXPECT_EQ(one->take().size(), 1U);
    all.clear();
    time.run_ready();
  }
}

TEST_F(HostEcologyInMemory, TwoThatReachEachOtherKeepTheConnectionOfTheHigherToken) {
  for (const bool shrink : {false, true}) {
    host.tokens_shrink = shrink;
    const auto before = host.listings();
    std::unique_ptr<Program> second;
    host.meanwhile([&] {
      second = begin();
      second->start(kTool);
    });
    auto first = begin();
    ASSERT_TRUE(second) << "it entered while the first looked for others";
    first->start(kIsland);
    time.run_ready();
    EXPECT_THAT(first->take(), ElementsAre("6541 met 70001"));
    EXPECT_THAT(second->take(), ElementsAre("70001 met 6541"));
    EXPECT_TRUE(first->ecology->knows_all() || second->ecology->knows_all());
    time.run_for(1s);
    EXPECT_TRUE(first->ecology->knows_all());
    EXPECT_TRUE(second->ecology->knows_all());
    EXPECT_THAT(first->take(), IsEmpty());
    EXPECT_THAT(second->take(), IsEmpty());
    EXPECT_EQ(host.listings() - before, 2U) << "each lists the folder once";
    first.reset();
    time.run_ready();
    EXPECT_THAT(second->take(), ElementsAre("70001 saw leave 6541"));
  }
}

TEST_F(HostEcologyInMemory, AnOwnerThatIsStoppedIsLostAfterALeaseAndFollowedAgainWhenItGoesOn) {
  auto island = begin(), tool = begin();
  auto& home = island->start(kIsland);
  auto& space = tool->start(kTool);
  const auto all = read_all(space);
  ASSERT_TRUE(home.set("lamp", "on"));
  ASSERT_TRUE(home.set("name", "home"));
  time.run_for(1s);
  tool->take();
  host.stop(island->number);
  time.run_for(1500ms);
  EXPECT_THAT(tool->take(), IsEmpty()) << "a stop shorter than the lease";
  time.run_for(4s);
  EXPECT_THAT(tool->take(), ElementsAre("70001 lost 6541"));
  time.run_for(2 * kOwnerGrace);
  EXPECT_EQ(value(space, kIsland, "name"), "");
  ASSERT_TRUE(home.set("lamp", "off"));  // before it reads anything
  host.go_on(island->number);
  time.run_for(100ms);
  EXPECT_THAT(tool->take(), ElementsAre("70001 met 6541"));
  EXPECT_EQ(value(space, kIsland, "lamp"), "off");
  EXPECT_EQ(value(space, kIsland, "name"), "home") << "what did not change meanwhile is in the snapshot";
  EXPECT_THAT(island->take(), testing::Not(testing::Contains(HasSubstr("lost"))));
  ASSERT_TRUE(home.set("lamp", "on"));
  time.run_for(100ms);
  EXPECT_EQ(value(space, kIsland, "lamp"), "on");
}

TEST_F(HostEcologyInMemory, NobodyAsksWhereNobodyDependsOnTheOther) {
  auto island = begin(), tool = begin();
  island->start(kIsland);
  tool->start(kTool);
  time.run_for(1s);
  tool->take();
  host.stop(island->number);
  time.run_for(1min);
  EXPECT_THAT(tool->take(), IsEmpty());
  host.go_on(island->number);
  time.run_for(1s);
  EXPECT_THAT(tool->take(), IsEmpty());
}

TEST_F(HostEcologyInMemory, AProcessThatWasStoppedItselfCallsNobodySilent) {
  auto island = begin(), tool = begin();
  island->start(kIsland);
  auto& space = tool->start(kTool);
  const auto all = read_all(space);
  time.run_for(3s);
  tool->take();
  for (int i = 0; i < 20; ++i) {
    time.stop_for(5s);
    time.run_for(200ms);
  }
  EXPECT_THAT(tool->take(), IsEmpty());
}

/// The question whether it lives waits behind 1 MB.
TEST_F(HostEcologyInMemory, AProcessThatReadsSlowlyLives) {
  auto island = begin(), tool = begin();
  auto& home = island->start(kIsland);
  const auto all = read_all(tool->start(kTool));
  time.run_for(1s);
  island->take();
  host.slow_down(tool->number, 10'000);
  const std::string picture(50'000, 'x');
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(home.set("picture-" + std::to_string(i % 100), picture));
    time.run_for(100ms);
  }
  EXPECT_THAT(island->take(), IsEmpty());
  host.stop(tool->number);
  time.run_for(4s);
  EXPECT_THAT(island->take(), ElementsAre("6541 lost 70001"));
}

TEST_F(HostEcologyInMemory, AStoppedProcessIsNamedUntilItTellsWhatItHas) {
  auto island = begin();
  island->start(kIsland);
  time.run_ready();
  host.stop(island->number);
  auto tool = begin();
  auto& space = tool->start(kTool);
  time.run_for(1s);
  EXPECT_FALSE(tool->ecology->knows_all());
  EXPECT_THAT(tool->ecology->awaited(), ElementsAre("pid 1 of uid 1000"));
  host.go_on(island->number);
  time.run_ready();
  EXPECT_TRUE(tool->ecology->knows_all());
  EXPECT_THAT(space.peers(), ElementsAre(kIsland));
}

TEST_F(HostEcologyInMemory, ACommandThatWaitedInTheSocketOfAStoppedOwnerEndsWithItsTime) {
  auto island = begin(), tool = begin();
  auto& home = island->start(kIsland);
  auto& space = tool->start(kTool);
  std::vector<std::string> taken;
  const auto policy = home.add_policy(pattern("door"), [&](const RemoteSet& set) {
    taken.push_back(set.value);
    return SetDecision::applied();
  });
  ASSERT_TRUE(home.set("door", "shut"));
  time.run_for(1s);
  host.stop(island->number);
  space.set_remote(kIsland, "door", "early", 500ms, {});
  space.set_remote(kIsland, "door", "in time", 10s, {});
  time.run_for(1s);
  host.go_on(island->number);
  time.run_for(100ms);
  EXPECT_THAT(taken, ElementsAre("in time"));
}

TEST_F(HostEcologyInMemory, AnIdIsTakenOnceOnTheHost) {
  auto first = begin(), second = begin();
  first->start(kIsland);
  const auto again = second->ecology->join(kIsland);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kDuplicate);
  EXPECT_THAT(again.error().text, HasSubstr("component 6541 runs already: pid 1"));
  host.kill(first->number);
  EXPECT_TRUE(second->ecology->join(kIsland)) << "the kernel ends the lock with the process";
}

TEST_F(HostEcologyInMemory, AStandInGoesWhenTheComponentItselfComes) {
  auto carrier = begin(), tool = begin();
  bool displaced = false;
  auto stand_in =
      std::move(*carrier->ecology->join_as({kIsland, marked_host("far", kOther), [&] { displaced = true; }}));
  auto there = std::make_unique<TupleSpace>(kIsland, time, *stand_in);
  ASSERT_TRUE(there->set("lamp", "copy"));
  auto& space = tool->start(kTool);
  const auto all = read_all(space);
  time.run_ready();
  EXPECT_EQ(value(space, kIsland, "lamp"), "copy");
  auto island = begin();
  ASSERT_TRUE(island->start(kIsland).set("lamp", "own"));
  time.run_ready();
  EXPECT_TRUE(displaced);
  EXPECT_EQ(value(space, kIsland, "lamp"), "own");
  there.reset();
  stand_in.reset();
  time.run_for(1s);
  EXPECT_EQ(value(space, kIsland, "lamp"), "own");
  EXPECT_THAT(space.peers(), ElementsAre(kIsland));
}

TEST_F(HostEcologyInMemory, AFolderThatWasEmptiedIsFilledAgainAndNobodyIsLost) {
  auto island = begin(), tool = begin();
  island->start(kIsland);
  auto& space = tool->start(kTool);
  const auto all = read_all(space);
  time.run_for(1s);
  tool->take();
  host.clean();
  time.run_for(2s);
  EXPECT_EQ(host.doors(), 2U);
  auto late = begin();
  auto& newcomer = late->start(kOther);
  time.run_ready();
  EXPECT_THAT(newcomer.peers(), ElementsAre(kIsland, kTool));
  EXPECT_THAT(tool->take(), ElementsAre("70001 met 70002"));
}

TEST_F(HostEcologyInMemory, TheLargestValueArrivesAndAReaderThatReadsNothingIsBounded) {
  auto island = begin(), tool = begin();
  auto& home = island->start(kIsland);
  auto& space = tool->start(kTool);
  const auto all = read_all(space);
  const std::string largest(std::size_t{1} << 20, 'x');
  ASSERT_TRUE(home.set("picture", largest));
  time.run_for(1s);
  EXPECT_EQ(value(space, kIsland, "picture"), largest);
  host.stop(tool->number);
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(home.set("picture", largest.substr(0, 1000 + static_cast<std::size_t>(i))));
    ASSERT_TRUE(home.set("other", largest));
    time.run_for(1ms);
  }
  EXPECT_LT(home.stats().queued, 10U) << "the latest values wait, not each";
  host.go_on(tool->number);
  time.run_for(1s);
  EXPECT_EQ(value(space, kIsland, "picture").size(), 1499U);
}

/// A program that is none of ours.
TEST_F(HostEcologyInMemory, WhoAsksWithoutEndAndReadsNothingTakesNoMemory) {
  auto island = begin();
  island->start(kIsland);
  const auto folder = host.enter();
  const auto number = ++programs;
  const auto token = folder->make_token();
  const auto listener = std::move(*folder->open(token, [](auto) { return transport::LocalCallbacks{}; }));
  std::size_t received = 0;
  std::unique_ptr<transport::LocalStream> stream;
  const auto doors = *folder->doors();
  for (const auto& door : doors) {
    if (door.token != token)
      stream = std::move(*folder->connect(door, {[&](ByteView bytes) { received += bytes.size(); }, nullptr, nullptr}));
  }
  ASSERT_TRUE(stream);
  Bytes hello, asks;
  append(hello, {Record::Type::kHello, {}, {}, kProtocolVersion, token});
  for (int i = 0; i < 1000; ++i) append(asks, {Record::Type::kAsk});
  ASSERT_TRUE(stream->write(hello));
  time.run_for(1ms);
  EXPECT_GT(received, 0U);
  host.stop(number);
  std::size_t asked = 0;
  while (asked < std::size_t{4} << 20) {
    asked += stream->write(asks).value_or(0);
    time.run_ready();
  }
  host.go_on(number);
  time.run_for(1ms);
  EXPECT_LT(received, 2 * MemoryHost::kRoom) << "what waits is an answer, too";
}

}  // namespace
}  // namespace rubicon::tuples::host
