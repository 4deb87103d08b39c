#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/mqtt/messages.h"
#include "tuples/mqtt/site.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

const transport::Endpoint kSpareBroker{"10.0.0.200", 1883};

/// Sites that meet only whom they deal with.
struct Meeting : testing::Test {
  std::unique_ptr<Site> site(OwnerId id) {
    auto one = std::make_unique<Site>(time, net, id, "10.0.1." + std::to_string(++addresses), options);
    EXPECT_TRUE(one->space->set("lamp", "off"));
    return one;
  }
  static Handle open(Site& site, std::vector<std::string>& decided) {
    return site.space->add_policy(pattern("lamp"), [&](const RemoteSet& set) {
      decided.push_back(set.value);
      return SetDecision::applied();
    });
  }
  /// What became of it; nullopt: nothing so far.
  std::shared_ptr<std::optional<Reply>> command(Site& from, OwnerId owner, std::string_view value,
                                                Duration lives = 5s) {
    auto got = std::make_shared<std::optional<Reply>>();
    from.space->set_remote(owner, "lamp", value, lives, [got](const Reply& reply) { *got = reply; });
    return got;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kBroker};
  SpaceOptions options = options_at({kBroker});
  std::vector<std::string> decided;
  int addresses = 0;
};

TEST_F(Meeting, NobodyHearsOfThoseItDoesNotDealWith) {
  std::vector<std::unique_ptr<Site>> sites;
  for (std::uint32_t id = 1; id <= 20; ++id) sites.push_back(site(OwnerId(id)));
  time.run_for(3s);
  auto tool = site(kRobot);
  Listener seen;
  const auto copies = tool->space->subscribe(pattern("7:**"), {}, seen.call());
  time.run_for(3s);
  EXPECT_THAT(seen.take(), ElementsAre("lamp=off"));
  EXPECT_THAT(tool->take(), ElementsAre("up 7"));
  EXPECT_THAT(sites[6]->take(), ElementsAre("up 70000")) << "who was spoken to knows who spoke";
  for (std::size_t i = 0; i < sites.size(); ++i) {
    EXPECT_TRUE(i == 6 || sites[i]->take().empty());
  }
}

TEST_F(Meeting, APatternOfAnyOwnerMeetsAll) {
  auto hall = site(kHall), lab = site(kLab), tool = site(kRobot);
  time.run_for(3s);
  EXPECT_THAT(tool->take(), IsEmpty());
  Listener seen;
  const auto copies = tool->space->subscribe(pattern("*:lamp"), {}, seen.call());
  time.run_for(3s);
  EXPECT_THAT(tool->take(), UnorderedElementsAre("up 1", "up 2"));
  EXPECT_THAT(hall->take(), ElementsAre("up 70000"));
  EXPECT_THAT(lab->take(), ElementsAre("up 70000"));
  auto late = site(OwnerId(3));
  time.run_for(3s);
  EXPECT_THAT(tool->take(), ElementsAre("up 3"));
  EXPECT_EQ(tool->value(OwnerId(3), "lamp"), "off");
}

/// Or a process with many stand-ins would need memory for each pair of one of them and one that it knows.
TEST_F(Meeting, OnlyThoseWhoDealHaveAChannel) {
  std::vector<std::unique_ptr<Site>> sites;
  for (std::uint32_t id = 1; id <= 20; ++id) sites.push_back(site(OwnerId(id)));
  const auto opened = open(*sites[6], decided);
  options.watch_all = true;
  auto tool = site(kRobot);
  auto second = std::move(*tool->ecology->join(OwnerId(70001)));
  TupleSpace space(OwnerId(70001), time, *second);
  time.run_for(3s);
  EXPECT_EQ(tool->space->peers().size(), 21U);
  EXPECT_EQ(tool->ecology->channels(), 0U);
  command(*tool, OwnerId(7), "on");
  time.run_for(1s);
  EXPECT_THAT(decided, ElementsAre("on"));
  EXPECT_EQ(tool->ecology->channels(), 1U);
  EXPECT_EQ(sites[6]->ecology->channels(), 1U);
  EXPECT_EQ(sites[5]->ecology->channels(), 0U);
}

TEST_F(Meeting, WhoLooksForTooManyMeetsAll) {
  auto hall = site(kHall), lab = site(kLab);
  std::vector<Handle> copies;
  for (std::uint32_t id = 10; id < 10 + Search::kMaxSought; ++id)
    copies.push_back(lab->space->subscribe({OwnerId(id), "lamp"}, {}, [](const Event&) {}));
  time.run_for(3s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
}

/// As tools do on a host.
TEST_F(Meeting, ThoseOfThisProcessThatComeAndGoLeaveNothing) {
  broker.keeps_published = false;
  auto hall = site(kHall), lab = site(kLab);
  time.run_for(3s);
  const auto before = broker.subscriptions();
  for (std::uint32_t id = 10; id < 10 + Search::kMaxSought; ++id) {
    const auto link = std::move(*lab->ecology->join(OwnerId(id)));
    TupleSpace tool(OwnerId(id), time, *link);
    const auto copies = tool.subscribe({OwnerId(100'000 + id), "lamp"}, {}, [](const Event&) {});
    time.run_for(10ms);
  }
  time.run_for(5s);
  EXPECT_EQ(broker.subscriptions(), before);
  EXPECT_THAT(lab->take(), Not(Contains("up 1")));
}

TEST_F(Meeting, AnOwnerIsLookedForUntilTheLastSubscriptionEnds) {
  auto hall = site(kHall), lab = site(kLab);
  const auto link = std::move(*lab->ecology->join(kRobot));
  TupleSpace tool(kRobot, time, *link);
  auto copies = lab->space->subscribe(pattern("1:lamp"), {}, [](const Event&) {});
  auto of_tool = tool.subscribe(pattern("1:lamp"), {}, [](const Event&) {});
  const auto restart = [&] {
    time.run_for(3s);
    lab->take();
    hall.reset();
    time.run_for(3s);
    hall = site(kHall);
    time.run_for(3s);
    return lab->take();
  };
  copies = {};
  EXPECT_THAT(restart(), ElementsAre("left 1", "up 1"));
  of_tool = {};
  time.run_for(3s);
  EXPECT_THAT(lab->space->peers(), Contains(kHall)) << "as long as it is there";
  EXPECT_THAT(restart(), ElementsAre("left 1"));
  const auto opened = open(*hall, decided);
  const auto sent = command(*lab, kHall, "on");
  time.run_for(2s);
  EXPECT_TRUE(sent->has_value() && (*sent)->verdict == Verdict::kApplied);
}

/// It was met before, because it dealt with this one.
TEST_F(Meeting, AnOwnerThatIsThereIsLookedForToo) {
  auto hall = site(kHall), lab = site(kLab);
  auto of_hall = hall->space->subscribe(pattern("2:lamp"), {}, [](const Event&) {});
  time.run_for(3s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, [](const Event&) {});
  time.run_for(3s);
  of_hall = {};
  hall.reset();
  time.run_for(3s);
  hall = site(kHall);
  time.run_for(3s);
  EXPECT_THAT(lab->take(), ElementsAre("left 1", "up 1"));
  EXPECT_EQ(lab->value(kHall, "lamp"), "off");
}

TEST_F(Meeting, ASetMeetsItsOwnerFirst) {
  broker.latency = 20ms;
  auto hall = site(kHall), lab = site(kLab);
  const auto opened = open(*hall, decided);
  time.run_for(3s);
  const auto one = command(*lab, kHall, "on"), other = command(*lab, kHall, "dim");
  time.run_for(2s);
  ASSERT_TRUE(one->has_value() && other->has_value());
  EXPECT_EQ((*one)->verdict, Verdict::kApplied);
  EXPECT_EQ((*other)->verdict, Verdict::kApplied);
  EXPECT_THAT(decided, ElementsAre("on", "dim")) << "in order";
}

/// What a component shows is known before its connection was read.
TEST_F(Meeting, WhoIsFarAwayIsMetToo) {
  auto hall = site(kHall), lab = site(kLab);
  time.run_for(3s);
  broker.latency = 2s;
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, seen.call());
  time.run_for(1min);
  EXPECT_THAT(seen.take(), ElementsAre("lamp=off"));
}

TEST_F(Meeting, ASetOvertakesNoneThatWaitsForTheOwner) {
  auto hall = site(kHall), lab = site(kLab);
  const auto opened = open(*hall, decided);
  time.run_for(3s);
  const auto later = lab->space->watch_peers([&](OwnerId, PeerEvent) { command(*lab, kHall, "second"); });
  command(*lab, kHall, "first");
  time.run_for(2s);
  EXPECT_THAT(decided, ElementsAre("first", "second"));
}

TEST_F(Meeting, WhoIsNotThereIsKnownOnlyAfterItWasLookedFor) {
  auto lab = site(kLab);
  const auto early = command(*lab, kHall, "on");
  EXPECT_FALSE(early->has_value());
  time.run_for(2s);
  ASSERT_TRUE(early->has_value());
  EXPECT_EQ((*early)->verdict, Verdict::kNoSuchOwner);
  broker.stop(true);
  time.run_for(1s);
  const auto cut = command(*lab, OwnerId(9), "on");
  time.run_for(4s);
  EXPECT_FALSE(cut->has_value()) << "nobody knows without the broker";
  time.run_for(2s);
  ASSERT_TRUE(cut->has_value());
  EXPECT_EQ((*cut)->verdict, Verdict::kExpired);
  EXPECT_THAT((*cut)->text, HasSubstr("was not sent"));
}

/// In the time in which the set waits for its owner, the owner comes.
TEST_F(Meeting, ASetThatWaitsReachesWhoComesMeanwhile) {
  broker.stop(true);
  auto lab = site(kLab);
  const auto sent = command(*lab, kHall, "on", 1min);
  time.run_for(2s);
  auto hall = site(kHall);
  const auto opened = open(*hall, decided);
  broker.start();
  time.run_for(30s);
  ASSERT_TRUE(sent->has_value());
  EXPECT_THAT(decided, ElementsAre("on"));
}

TEST_F(Meeting, AConnectionThatComesBackLosesNobody) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, seen.call());
  const auto opened = open(*hall, decided);
  time.run_for(3s);
  hall->take(), lab->take();
  for (int i = 0; i < 20; ++i) {
    i % 2 ? broker.cut() : broker.cut(broker.clients().front());
    EXPECT_TRUE(hall->space->set("lamp", std::to_string(i)));
    time.run_for(5s);
    EXPECT_EQ(lab->value(kHall, "lamp"), std::to_string(i));
    const auto sent = command(*lab, kHall, "on");
    time.run_for(2s);
    EXPECT_TRUE(sent->has_value() && (*sent)->verdict == Verdict::kApplied);
  }
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_THAT(hall->take(), IsEmpty());
  time.run_for(1min);
  EXPECT_EQ(broker.retained().size(), 4U) << "what earlier connections showed is gone";
  lab.reset();
  time.run_for(1s);
  EXPECT_THAT(hall->take(), ElementsAre("left 2")) << "by its newest connection";
}

/// Both begin new connections, and each knows the other one by an old one only.
TEST_F(Meeting, ABrokerThatForgotAllKeepsThoseWhoDeal) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, seen.call());
  time.run_for(3s);
  hall->take(), lab->take();
  broker.stop(false);
  time.run_for(3s);
  EXPECT_TRUE(hall->space->set("lamp", "on"));
  broker.start();
  time.run_for(1min);
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_THAT(hall->take(), IsEmpty());
  EXPECT_EQ(lab->value(kHall, "lamp"), "on");
}

/// Presence of a dead process that expires, and an end that a broker dropped: both are silent.
TEST_F(Meeting, WhatWasMissedIsNoticedWhenPresenceIsReadAgain) {
  options.watch_all = true;
  auto hall = site(kHall), lab = site(kLab);
  time.run_for(3s);
  lab->take();
  broker.loses = [](const std::string&, const transport::MqttPublication& message) {
    return message.topic.find("/p/") != std::string::npos && message.topic.ends_with("/1");
  };
  hall->space.reset();
  hall->link.reset();
  time.run_for(1s);
  broker.loses = {};
  EXPECT_THAT(lab->take(), IsEmpty()) << "its line is still there";
  time.run_for(25min);
  EXPECT_THAT(lab->take(), ElementsAre("lost 1"));
}

TEST_F(Meeting, OneUserCannotFillTheRoomOfAll) {
  options.watch_all = true;
  auto lab = site(kLab);
  time.run_for(2s);
  const std::string root = "rubicon-space/1/default/p/a/mad/";
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    const auto line = fmt::format("{:011x}a", i);
    broker.publish(root + line, line_text({1, 20s}), true);
    broker.publish(root + line + "/" + std::to_string(100'000 + i),
                   component_text({2'000'000'000'000'000, "host", std::string(3000, 'x')}), true);
    if (i % 500 == 0) time.run_for(10ms);
  }
  time.run_for(1s);
  EXPECT_LT(lab->ecology->presence_bytes(), std::size_t{9} << 20);
  EXPECT_TRUE(lab->log.contains("user mad shows too many components"));
  auto hall = site(kHall);
  lab->take();
  time.run_for(2s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
  EXPECT_GT(lab->space->peers().size(), 1000U) << "and those that fit";
}

/// Only one side notices that they were apart.
TEST_F(Meeting, WhoWasLostByOneSideOnlySubscribesAgain) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, seen.call());
  time.run_for(3s);
  hall->take(), lab->take();
  std::string topic;
  for (const auto& one : broker.published()) {
    if (!one.topic.ends_with("/2")) continue;
    topic = one.topic;
    broker.loses = [lab = one.client](const std::string& client, const transport::MqttPublication& message) {
      return client == lab && message.topic.ends_with("/2");
    };
  }
  broker.publish(topic, {}, true);
  time.run_for(4s);
  broker.loses = {};
  EXPECT_THAT(hall->take(), ElementsAre("lost 2"));
  EXPECT_THAT(lab->take(), IsEmpty());
  for (const auto& client : broker.clients()) broker.cut(client);
  EXPECT_TRUE(hall->space->set("lamp", "on"));
  time.run_for(10s);
  EXPECT_THAT(hall->take(), ElementsAre("up 2"));
  EXPECT_EQ(lab->value(kHall, "lamp"), "on");
  EXPECT_THAT(lab->take(), IsEmpty());
}

/// The limits of brokers, and what they say about them.
struct Large : Meeting {
  void trade(Site& hall, Site& lab, Duration within) {
    Listener seen;
    const auto copies = lab.space->subscribe(pattern("1:**"), {}, seen.call());
    const auto opened = open(hall, decided);
    time.run_for(3s);
    EXPECT_TRUE(hall.space->set("large", noise(200'000)));
    EXPECT_TRUE(hall.space->set("lamp", "after"));
    const auto sent = command(lab, kHall, noise(200'000), 2min), then = command(lab, kHall, "then", 2min);
    time.run_for(within);
    EXPECT_EQ(lab.value(kHall, "lamp"), "then") << "what follows goes on";
    EXPECT_EQ(lab.value(kHall, "large"), "none");
    EXPECT_TRUE(hall.log.contains("component 2 does not get it: large with its value has 200"));
    ASSERT_TRUE(sent->has_value() && then->has_value());
    EXPECT_EQ((*sent)->code, ErrorCode::kOutOfRange) << (*sent)->text;
    EXPECT_EQ((*then)->verdict, Verdict::kApplied);
    EXPECT_THAT(decided, ElementsAre("then"));
    EXPECT_EQ(hall.ecology->counters().too_large, 1U);
    EXPECT_TRUE(hall.space->set("large", noise(90'000)));
    time.run_for(20s);
    EXPECT_EQ(lab.value(kHall, "large").size(), 90'000U) << "smaller ones pass";
    EXPECT_TRUE(hall.space->set("large", noise(250'000)));
    time.run_for(1min);
    EXPECT_EQ(hall.ecology->counters().too_large, 2U);
    EXPECT_THAT(lab.take(), ElementsAre("up 1")) << "nobody was lost";
  }
};

TEST_F(Large, ABrokerThatTellsItsLimit) {
  broker.largest_packet = 100'000;
  auto hall = site(kHall), lab = site(kLab);
  trade(*hall, *lab, 1s);
}

TEST_F(Large, ABrokerThatTellsWhatItDidNotTake) {
  broker.largest_payload = 100'000;
  auto hall = site(kHall), lab = site(kLab);
  trade(*hall, *lab, 1s);
}

TEST_F(Large, ABrokerThatTellsNothing) {
  broker.largest_payload = 100'000;
  broker.speaks_5 = false;
  auto hall = site(kHall), lab = site(kLab);
  trade(*hall, *lab, 15s);
}

/// It would have said so: what does not arrive was lost.
TEST_F(Large, ABrokerThatTellsItsLimitGetsTheValueAsOftenAsItIsLost) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:**"), {}, seen.call());
  time.run_for(3s);
  broker.loses = [](const std::string&, const transport::MqttPublication& message) {
    return message.payload.size() > 100'000;
  };
  EXPECT_TRUE(hall->space->set("large", noise(200'000)));
  time.run_for(1s);
  EXPECT_TRUE(hall->space->set("lamp", "after"));
  time.run_for(1min);
  EXPECT_EQ(lab->value(kHall, "lamp"), "off");
  broker.loses = {};
  time.run_for(10s);
  EXPECT_EQ(lab->value(kHall, "large").size(), 200'000U);
  EXPECT_EQ(lab->value(kHall, "lamp"), "after");
  EXPECT_EQ(hall->ecology->counters().too_large, 0U);
}

/// What was accepted waits for a broker that comes back with a lower limit.
TEST_F(Large, ALimitThatIsLowerAfterARestart) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:**"), {}, seen.call());
  time.run_for(3s);
  broker.stop(true);
  EXPECT_TRUE(hall->space->set("large", noise(200'000)));
  time.run_for(1s);
  EXPECT_TRUE(hall->space->set("lamp", "after"));
  broker.largest_packet = 100'000;
  broker.start();
  time.run_for(15s);
  EXPECT_EQ(lab->value(kHall, "lamp"), "after");
  EXPECT_TRUE(hall->log.contains("large with its value has 200"));
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
}

struct Spare : Meeting {
  Spare() { options = options_at({kBroker, kSpareBroker}); }
  transport::MqttBroker spare{net, kSpareBroker};
};

TEST_F(Spare, TheSecondBrokerServesWhileTheFirstIsAway) {
  auto hall = site(kHall), lab = site(kLab);
  Listener seen;
  const auto copies = lab->space->subscribe(pattern("1:lamp"), {}, seen.call());
  time.run_for(3s);
  hall->take(), lab->take();
  EXPECT_THAT(spare.clients(), IsEmpty());
  broker.stop(false);
  EXPECT_TRUE(hall->space->set("lamp", "on"));
  time.run_for(1min);
  EXPECT_EQ(spare.clients().size(), 2U);
  EXPECT_EQ(lab->value(kHall, "lamp"), "on");
  EXPECT_TRUE(hall->space->set("lamp", "dim"));
  time.run_for(1s);
  EXPECT_EQ(lab->value(kHall, "lamp"), "dim");
  broker.start();
  time.run_for(4min);
  EXPECT_EQ(broker.clients().size(), 2U) << "back at the first one";
  EXPECT_THAT(spare.clients(), IsEmpty());
  EXPECT_THAT(spare.retained(), IsEmpty());
  EXPECT_TRUE(hall->space->set("lamp", "off"));
  time.run_for(1s);
  EXPECT_EQ(lab->value(kHall, "lamp"), "off");
}

TEST_F(Spare, OneThatRefusesIsLeftAtOnce) {
  broker.users = {{"ann", "secret"}};
  auto hall = site(kHall);
  time.run_for(3s);
  EXPECT_EQ(spare.clients().size(), 1U);
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
