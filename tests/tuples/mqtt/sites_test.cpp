#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tuples/distant/frame_codec.h"
#include "tuples/mqtt/site.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

struct Sites : testing::Test {
  Sites() { start(); }
  void start() {
    hall = site(kHall, "10.0.0.2");
    lab = site(kLab, "10.0.0.3");
    open = hall->space->add_policy(pattern("lamp"), [this](const RemoteSet& set) {
      decided.push_back(set.value);
      return SetDecision::applied();
    });
    EXPECT_TRUE(hall->space->set("lamp", "off"));
    copies = lab->space->subscribe(pattern("1:**"), {}, seen.call());
    time.run_for(2s);
    EXPECT_THAT(lab->take(), ElementsAre("up 1"));
    EXPECT_THAT(hall->take(), ElementsAre("up 2"));
    EXPECT_THAT(seen.take(), ElementsAre("lamp=off"));
  }
  std::unique_ptr<Site> site(OwnerId id, const std::string& address) {
    auto options = options_at({kBroker});
    options.watch_all = true;
    return std::make_unique<Site>(time, net, id, address, options);
  }
  Verdict command(const std::string& value, Duration lives = 5s) {
    std::optional<Verdict> verdict;
    lab->space->set_remote(kHall, "lamp", value, lives, [&](const Reply& reply) { verdict = reply.verdict; });
    time.run_for(lives + 1s);
    return verdict.value_or(Verdict::kRefused);
  }
  /// Somebody who writes by hand.
  std::unique_ptr<transport::MqttLine> stranger(const std::string& address = "10.0.0.9") {
    strangers.push_back(std::make_unique<transport::MemoryTransports>());
    strangers.back()->join(net, address);
    transport::MqttOptions options;
    options.host = kBroker.address;
    options.client_id = "stranger" + std::to_string(strangers.size());
    transport::MqttCallbacks calls;
    calls.connected = [](const transport::MqttConnack&) {};
    calls.received = [](const transport::MqttMessage&) {};
    calls.failed = [](const Error&) {};
    auto line = std::move(*strangers.back()->open_mqtt(options, calls));
    time.run_for(1s);
    return line;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kBroker};
  std::vector<std::string> decided;
  Listener seen;
  std::vector<std::unique_ptr<transport::MemoryTransports>> strangers;
  std::unique_ptr<Site> hall, lab;
  Handle open, copies;
};

TEST_F(Sites, ReadAndCommandEachOther) {
  EXPECT_FALSE(lab->ecology->seeks(std::nullopt));
  EXPECT_EQ(command("on"), Verdict::kApplied);
  EXPECT_THAT(decided, ElementsAre("on"));
  EXPECT_THAT(seen.take(), ElementsAre("lamp=on"));
}

TEST_F(Sites, AnEndIsSeenAtOnce) {
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  time.run_for(10ms);
  EXPECT_THAT(lab->take(), ElementsAre("left 1"));
  EXPECT_TRUE(broker.retained().size() == 2) << "nothing is left of it at the broker";
}

TEST_F(Sites, OneThatIsCutIsLostASecondAfterItsLeaseAtTheLatest) {
  const auto& all = broker.published();
  const auto of_hall = std::find_if(all.begin(), all.end(), [](const auto& one) { return one.topic.ends_with("/1"); });
  ASSERT_NE(of_hall, all.end());
  broker.stall(of_hall->client, true);
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  time.run_for(21s);
  EXPECT_THAT(lab->take(), ElementsAre("lost 1"));
}

TEST_F(Sites, AConnectionThatComesBackLosesNobodyAndNothing) {
  for (int i = 0; i < 20; ++i) {
    broker.cut();
    EXPECT_TRUE(hall->space->set("lamp", std::to_string(i)));
    time.run_for(2s);
    EXPECT_EQ(lab->value(kHall, "lamp"), std::to_string(i));
  }
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_THAT(hall->take(), IsEmpty());
  EXPECT_EQ(seen.take().size(), 20U) << "no snapshot again";
  time.run_for(1min);
  EXPECT_EQ(broker.retained().size(), 4U) << "what earlier connections showed is gone";
}

TEST_F(Sites, ABrokerThatForgetsAllAtItsRestartIsFilledAgain) {
  broker.stop(false);
  time.run_for(3s);
  EXPECT_TRUE(hall->space->set("lamp", "on"));
  broker.start();
  time.run_for(15s);
  EXPECT_EQ(lab->value(kHall, "lamp"), "on");
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_EQ(command("dim"), Verdict::kApplied);
}

/// While presence is read, part after part, the topics of an earlier connection are emptied before those of its
/// successor are read.
TEST_F(Sites, LoseNobodyWhoIsBackFirst) {
  bool lost = false;
  int fences = 0;  // messages to itself, one a part
  broker.loses = [&](const std::string& client, const transport::MqttPublication& message) {
    const auto& all = broker.published();
    const bool to_lab = std::any_of(all.begin(), all.end(), [&](const transport::MqttBroker::Publication& one) {
      return one.client == client && one.topic.ends_with("/2");
    });
    return to_lab && !lost && message.payload.starts_with('\xff') && ++fences == 9 && !std::exchange(lost, true);
  };
  for (int i = 0; i < 20; ++i) {  // which part it is in is random
    broker.stop(false);
    broker.forget_published();
    lost = false;
    fences = 0;
    broker.start();
    time.run_for(20s);
    ASSERT_TRUE(lost);
    ASSERT_FALSE(lab->ecology->seeks(std::nullopt));
    EXPECT_THAT(lab->take(), IsEmpty()) << i;
  }
}

TEST_F(Sites, AnEndIsSeenAtOnceOnALaterConnectionToo) {
  broker.stop(false);
  broker.start();
  time.run_for(5s);
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  time.run_for(10ms);
  EXPECT_THAT(lab->take(), ElementsAre("left 1"));
}

TEST_F(Sites, AreLostAfterTheirLeaseWithoutABrokerAndMetAgain) {
  broker.stop(true);
  time.run_for(25s);
  EXPECT_THAT(lab->take(), ElementsAre("lost 1"));
  EXPECT_EQ(command("on"), Verdict::kExpired) << "without the broker nobody knows";
  EXPECT_TRUE(hall->space->set("lamp", "dim"));
  broker.start();
  time.run_for(30s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
  EXPECT_EQ(lab->value(kHall, "lamp"), "dim");
  EXPECT_EQ(command("on"), Verdict::kApplied);
}

/// Of the time before the broker stopped: its connection is no longer, but its topics are retained.
TEST_F(Sites, WhatIsLeftOfADeadConnectionIsNobody) {
  const auto saved = broker.retained();
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  time.run_for(1s);
  EXPECT_THAT(lab->take(), ElementsAre("left 1"));
  broker.restart(saved);
  time.run_for(15s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1")) << "its topics say so";
  EXPECT_EQ(command("on", 30s), Verdict::kTimedOut);
  time.run_for(1min);
  EXPECT_THAT(lab->take(), ElementsAre("lost 1")) << "it acknowledges nothing";
  EXPECT_EQ(command("on"), Verdict::kNoSuchOwner);
  hall = site(kHall, "10.0.0.2");
  time.run_for(5s);
  EXPECT_THAT(lab->take(), ElementsAre("up 1"));
  EXPECT_THAT(hall->displaced, IsEmpty()) << "who is dead answers nothing";
}

/// What a killed process showed goes by itself; what lives is written again before.
TEST_F(Sites, WhatIsRetainedEndsAfterAnHour) {
  const auto line = stranger();
  time.run_for(3h);
  EXPECT_EQ(broker.retained().size(), 4U);
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_EQ(command("on"), Verdict::kApplied);
  const auto saved = broker.retained();
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  lab.reset();
  for (const auto& [topic, payload] : saved) EXPECT_TRUE(line->publish({topic, payload, true, 0, {}, 1h, 0}));
  time.run_for(2h);
  EXPECT_THAT(broker.retained(), IsEmpty());
}

TEST_F(Sites, OfTwoWithOneIdTheLaterOneEnds) {
  const auto twin = site(kHall, "10.0.0.4");
  time.run_for(5s);
  EXPECT_THAT(twin->displaced, ElementsAre(kHall));
  EXPECT_THAT(hall->displaced, IsEmpty());
}

/// The question is asked again each second.
TEST_F(Sites, AnAnswerThatTakesSecondsCounts) {
  broker.latency = 1s;
  const auto twin = site(kHall, "10.0.0.4");
  time.run_for(1min);
  EXPECT_THAT(twin->displaced, ElementsAre(kHall));
  EXPECT_THAT(hall->displaced, IsEmpty());
}

TEST_F(Sites, WhatStrangersWriteIsDroppedAndCounted) {
  const auto line = stranger();
  const auto before = lab->ecology->counters().foreign;
  const std::string root = "rubicon-space/1/default/";
  const auto write = [&](const std::string& topic, const std::string& payload, bool retain = true) {
    EXPECT_TRUE(line->publish({root + topic, payload, retain, 0, {}, {}, 0}));
  };
  write("p/a/ann/00000000000a/1", std::string("\2\1", 2));
  write("p/a/ann/00000000000a", "not a version");
  write("p/a/ann/00000000000a/1/2", "x");
  write("p/a/ann/00000000000b", "the wrong part");
  write("p/a/ann/00000000000a/3", std::string(1'000'000, 'x'));
  time.run_for(1s);
  EXPECT_EQ(lab->ecology->counters().foreign - before, 5U);
  EXPECT_TRUE(lab->log.contains("of version 2 of the protocol"));
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_EQ(command("on"), Verdict::kApplied);
}

/// With the same start and host, which all can read.
TEST_F(Sites, NobodyTakesTheIdOfAnotherUser) {
  const auto line = stranger();
  const std::string root = "rubicon-space/1/default/p/a/";
  for (const auto& [topic, payload] : std::map(broker.retained())) {
    if (!topic.ends_with("/2")) continue;
    EXPECT_TRUE(line->publish({root + "!/00000000000a", line_text({99, 20s}), true, 0, {}, {}, 0}));
    EXPECT_TRUE(line->publish({root + "!/00000000000a/2", payload, true, 0, {}, {}, 0}));
  }
  time.run_for(2s);
  EXPECT_THAT(hall->take(), IsEmpty());
  EXPECT_EQ(command("on"), Verdict::kApplied) << "who was hurt still commands";
}

/// Its user is nobody's: it writes what it likes, in the name of this process too.
TEST_F(Sites, NobodySpeaksInTheNameOfTheOwnProcess) {
  auto console = std::move(*hall->ecology->join(OwnerId(70001)));
  TupleSpace of_console(OwnerId(70001), time, *console);
  time.run_for(2s);
  std::optional<Verdict> verdict;
  of_console.set_remote(kHall, "lamp", "own", 5s, [&](const Reply& reply) { verdict = reply.verdict; });
  time.run_for(1s);
  EXPECT_EQ(verdict, Verdict::kApplied);
  FrameHead head;
  std::string line;
  for (const auto& [topic, payload] : broker.retained()) {
    if (topic.ends_with("/1")) line = topic.substr(topic.size() - 14, 12);
    if (!topic.ends_with("/1") && !topic.ends_with("/70001")) continue;
    const auto shown = read_component(payload);
    (topic.ends_with("/1") ? head.target_incarnation : head.source_incarnation) = shown->incarnation;
  }
  head.source = OwnerId(70001);
  head.target = kHall;
  head.stream = std::uint64_t{1} << 60;
  head.number = head.first = 1;
  distant::FrameWriter entry;
  RemoteSet set;
  set.request = 1000;
  set.key = "lamp";
  set.value = "stolen";
  entry.add(set);
  const auto frame = frame_of(head, entry.view());
  const auto thief = stranger();
  EXPECT_TRUE(thief->publish(
      {"rubicon-space/1/default/to/-/" + line + "/-/" + line, std::string(base::as_text(frame)), false, 0, {}, {}, 0}));
  time.run_for(1s);
  EXPECT_THAT(decided, ElementsAre("own"));
  EXPECT_TRUE(hall->log.contains("in the name of component 70001 of this process"));
}

/// As the page of an island does, which is a component of its own.
TEST_F(Sites, ComponentsOfOneProcessMeetAndStayWithoutABroker) {
  const auto join = [this](OwnerId id) { return std::move(*hall->ecology->join(id)); };
  const auto command_of = [this](TupleSpace& space) {
    Verdict verdict = Verdict::kTimedOut;
    space.set_remote(kHall, "lamp", "on", 2s, [&](const Reply& reply) { verdict = reply.verdict; });
    time.run_for(3s);
    return verdict;
  };
  auto page = join(OwnerId(70001));
  auto of_page = std::make_unique<TupleSpace>(OwnerId(70001), time, *page);
  time.run_for(2s);
  EXPECT_THAT(hall->take(), ElementsAre("up 70001"));
  broker.stop(true);
  time.run_for(10min);
  EXPECT_THAT(hall->take(), ElementsAre("lost 2"));
  EXPECT_EQ(command_of(*of_page), Verdict::kApplied);
  auto tool = join(OwnerId(70002));
  auto of_tool = std::make_unique<TupleSpace>(OwnerId(70002), time, *tool);
  time.run_for(1s);
  EXPECT_THAT(hall->take(), ElementsAre("up 70002"));
  EXPECT_EQ(command_of(*of_tool), Verdict::kApplied);
  of_tool.reset();
  tool.reset();
  time.run_for(1s);
  EXPECT_THAT(hall->take(), ElementsAre("left 70002"));
  broker.start();
  time.run_for(1min);
  EXPECT_THAT(hall->take(), ElementsAre("up 2"));
  EXPECT_EQ(command_of(*of_page), Verdict::kApplied);
  of_page.reset();
  page.reset();
  time.run_for(1s);
  EXPECT_THAT(hall->take(), ElementsAre("left 70001"));
}

/// No broker has ever been there.
TEST_F(Sites, ComponentsOfOneProcessMeetBeforeTheFirstConnection) {
  broker.stop(true);
  const auto yard = site(OwnerId(3), "10.0.0.9");
  auto page = std::move(*yard->ecology->join(OwnerId(70001)));
  const auto of_page = std::make_unique<TupleSpace>(OwnerId(70001), time, *page);
  time.run_for(1s);
  EXPECT_THAT(yard->take(), ElementsAre("up 70001"));
}

/// It is shown for a moment after it ended.
TEST_F(Sites, OneOfThisProcessThatJustEndedGetsNothingMore) {
  broker.latency = 100ms;
  auto console = std::move(*hall->ecology->join(OwnerId(70001)));
  auto of_console = std::make_unique<TupleSpace>(OwnerId(70001), time, *console);
  const auto values = of_console->subscribe(pattern("1:**"), {}, [](const Event&) {});
  time.run_for(2s);
  of_console.reset();
  console.reset();
  EXPECT_TRUE(hall->space->set("lamp", "after"));
  time.run_for(2s);
  EXPECT_EQ(hall->ecology->counters().foreign, 0U);
}

/// The broker lets it write to the inbox of another, in its own name.
TEST_F(Sites, NobodySpeaksInTheNameOfAnother) {
  std::string inbox;
  for (const auto& [topic, payload] : broker.retained()) {
    if (topic.ends_with("/1")) inbox = "rubicon-space/1/default/to/-/" + topic.substr(topic.size() - 14, 12);
  }
  const auto line = stranger();
  FrameHead head;
  head.source = kLab;
  head.target = kHall;
  for (const auto& one : broker.retained()) {
    if (!one.first.ends_with("/1") && !one.first.ends_with("/2")) continue;
    const auto shown = read_component(one.second);
    (one.first.ends_with("/1") ? head.target_incarnation : head.source_incarnation) = shown->incarnation;
  }
  head.stream = std::uint64_t{1} << 60;
  head.number = head.first = 1;
  distant::FrameWriter entry;
  RemoteSet set;
  set.request = 1000;
  set.key = "lamp";
  set.value = "stolen";
  entry.add(set);
  const auto frame = frame_of(head, entry.view());
  EXPECT_TRUE(line->publish({inbox + "/thief/00000000000f", std::string(base::as_text(frame)), false, 0, {}, {}, 0}));
  time.run_for(1s);
  EXPECT_TRUE(hall->log.contains("a frame in the name of component 2 of user thief: dropped"));
  EXPECT_THAT(decided, IsEmpty());
}

TEST_F(Sites, TheWillOfAnOldConnectionComesAfterTheNewOne) {
  auto old = broker.retained();
  broker.cut();
  time.run_for(5s);
  const auto line = stranger();
  for (const auto& [topic, payload] : old) EXPECT_TRUE(line->publish({topic, {}, true, 0, {}, {}, 0}));
  time.run_for(10s);
  EXPECT_THAT(lab->take(), IsEmpty());
  EXPECT_EQ(command("on"), Verdict::kApplied);
}

TEST_F(Sites, ABrokerThatHandsOnNothingIsNamedAndAskedAgain) {
  broker.ignored_topics = {"#"};
  const auto robot = site(kRobot, "10.0.0.5");
  time.run_for(30s);
  EXPECT_TRUE(robot->log.contains("does not deliver what - sends to itself"));
  EXPECT_TRUE(robot->ecology->seeks(std::nullopt));
  broker.ignored_topics.clear();
  time.run_for(15s);
  EXPECT_FALSE(robot->ecology->seeks(std::nullopt));
}

/// All owners send at once; the broker drops what exceeds its queue.
TEST_F(Sites, OneWhoAsksManyGetsTheirValuesOnce) {
  constexpr std::size_t kSites = 60, kValues = 20, kBytes = 20'000;
  const auto before = broker.clients();
  const auto robot = site(kRobot, "10.0.0.5");
  while (broker.clients().size() == before.size()) time.run_for(1ms);
  for (const auto& client : broker.clients()) {
    if (!std::binary_search(before.begin(), before.end(), client)) broker.slow(client, 1ms);
  }
  std::vector<std::unique_ptr<Site>> all;
  for (std::size_t i = 0; i < kSites; ++i) {
    all.push_back(site(OwnerId(static_cast<std::uint32_t>(100 + i)), fmt::format("10.1.0.{}", i + 1)));
    for (std::size_t j = 0; j < kValues; ++j)
      EXPECT_TRUE(all.back()->space->set(fmt::format("value.{}", j), noise(kBytes)));
  }
  time.run_for(30s);
  std::size_t bytes = 0, came = 0;
  broker.heard = [&](const transport::MqttBroker::Publication& one) { bytes += one.payload.size(); };
  const auto values = robot->space->subscribe(pattern("value.*"), {}, [&](const Event&) { ++came; });
  time.run_for(1min);
  EXPECT_EQ(came, kSites * kValues);
  EXPECT_LT(bytes, kSites * kValues * kBytes * 11 / 10) << "nothing is sent again";
}

TEST_F(Sites, WhyThereIsNoConnectionIsKnown) {
  broker.users = {{"ann", "secret"}};
  broker.cut();
  time.run_for(2min);
  EXPECT_THAT(lab->ecology->trouble(), HasSubstr("refuse"));
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
