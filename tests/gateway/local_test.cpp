#include <optional>

#include "gateway/islands.h"

namespace rubicon::gateway {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class LocalGateway : public Islands {
 protected:
  std::int64_t value(const Message& message) const {
    return std::get<std::int64_t>(std::get<model::Updates>(message.body).readings.at(0).value);
  }
};

TEST_F(LocalGateway, DeliversInALaterTurnAndInOrder) {
  one.listen(MessageKind::kUpdates);
  one.listen(MessageKind::kJoin);
  one.network("a").say("7", model::Join{});
  one.network("a").say("7", reading(1));
  one.network("a").say("7", reading(2));
  EXPECT_THAT(one.heard, IsEmpty());
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(3));
  EXPECT_EQ(one.heard[0].kind(), MessageKind::kJoin);
  EXPECT_EQ(value(one.heard[1]), 1);
  EXPECT_EQ(value(one.heard[2]), 2);
  EXPECT_EQ(one.gateway.counters("a").delivered, 3u);
}

TEST_F(LocalGateway, StampsOriginAndRisingNumbers) {
  one.listen(MessageKind::kKeepAlive);
  one.network("a").say("7", model::KeepAlive{});
  one.network("b").say("7", model::KeepAlive{});
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(2));
  EXPECT_EQ(one.heard[0].origin, OwnerId{1});
  EXPECT_GT(one.heard[1].number, one.heard[0].number);
  EXPECT_GT(one.heard[0].number, static_cast<std::uint64_t>(time.wall_now().time_since_epoch().count()));
}

TEST_F(LocalGateway, DropsTheOldestReadingsBeyondTheBoundAndCountsThem) {
  one.listen(MessageKind::kUpdates);
  one.listen(MessageKind::kLeave);
  one.network("a").say("6", model::Leave{});
  for (std::int64_t i = 0; i < 1000; ++i) one.network("a").say("7", reading(i, 2));
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(51));
  EXPECT_EQ(one.heard[0].kind(), MessageKind::kLeave);
  EXPECT_EQ(value(one.heard[1]), 950);
  EXPECT_EQ(value(one.heard[50]), 999);
  EXPECT_EQ(one.gateway.counters("a").dropped_readings, 1900u);
  EXPECT_EQ(one.gateway.counters("b").dropped_readings, 0u);
  EXPECT_EQ(one.gateway.counters().dropped_readings, 1900u);
  EXPECT_TRUE(log.contains("1900 readings dropped"));
}

TEST_F(LocalGateway, DropsTheOldestReadingsBeyondTheBoundOfBytes) {
  one.listen(MessageKind::kUpdates);
  const std::string text(1 << 20, 'x');
  for (int i = 0; i < 20; ++i) {
    model::Updates updates;
    updates.readings.push_back({kMeter, text, {}});
    one.network("a").say(std::to_string(i), std::move(updates));
  }
  for (std::int64_t i = 0; i < 3; ++i) one.network("b").say("7", reading(i));
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(16 + 3)) << "16 MiB";
  EXPECT_EQ(one.heard[0].source.device, "4");
  EXPECT_EQ(one.gateway.counters("a").dropped_readings, 4u);
  for (int i = 0; i < 16; ++i) {
    model::Updates updates;
    updates.readings.push_back({kMeter, text, {}});
    one.network("a").say("next turn", std::move(updates));
  }
  time.run_ready();
  EXPECT_EQ(one.gateway.counters("a").dropped_readings, 4u) << "a new turn has all the room";
}

TEST_F(LocalGateway, RefusesOthersBeyondTheBoundOfBytes) {
  one.listen(MessageKind::kState);
  for (int i = 0; i < 20; ++i) {
    model::State state{model::LineState::kUp, {}, {}};
    for (int part = 0; part < 16; ++part) state.texts["part-" + std::to_string(part)] = std::string(1 << 16, 'x');
    one.network("a").say({}, std::move(state));
  }
  time.run_ready();
  EXPECT_THAT(one.heard, SizeIs(16)) << "16 MiB";
  EXPECT_EQ(one.gateway.counters("a").refused_busy, 4u);
}

TEST_F(LocalGateway, HoldsItsBoundsUnderAFloodOfEveryKind) {
  std::size_t joins = 0, updates = 0;
  auto count_joins = one.gateway.subscribe(MessageKind::kJoin, [&](const Message&) { ++joins; });
  auto count_updates = one.gateway.subscribe(MessageKind::kUpdates, [&](const Message&) { ++updates; });
  for (int i = 0; i < 20000; ++i) {
    const auto device = std::to_string(i % 50);
    one.network("a").say(device, model::Join{});
    one.network("a").say(device, reading(i));
    one.network("a").say(device, model::KeepAlive{});
  }
  time.run_ready();
  EXPECT_EQ(joins, 20u);
  EXPECT_EQ(updates, 100u);
  EXPECT_GT(one.gateway.counters("a").refused_busy, 0u);
}

TEST_F(LocalGateway, KeepsTheNewestJoinOfADeviceInTheOldestsPlace) {
  one.listen(MessageKind::kJoin);
  one.listen(MessageKind::kUpdates);
  one.network("a").say("7", model::Join{.device_type = {}, .name = "old", .model = {}, .capabilities = {}});
  one.network("a").say("7", reading(1));
  one.network("a").say("7", model::Join{.device_type = {}, .name = "new", .model = {}, .capabilities = {}});
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(2));
  EXPECT_EQ(std::get<model::Join>(one.heard[0].body).name, "new");
}

TEST_F(LocalGateway, AJoinAfterALeaveIsNotMergedWithTheOneBefore) {
  one.listen(MessageKind::kJoin);
  one.listen(MessageKind::kLeave);
  one.network("a").say("7", model::Join{});
  one.network("a").say("7", model::Leave{});
  one.network("a").say("7", model::Join{});
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(3));
  EXPECT_EQ(one.heard[2].kind(), MessageKind::kJoin);
}

TEST_F(LocalGateway, ASignOfLifeAfterUnreachableIsNotMergedWithTheOneBefore) {
  for (const auto kind : {MessageKind::kJoin, MessageKind::kKeepAlive, MessageKind::kUnreachable}) one.listen(kind);
  for (int i = 0; i < 2; ++i) {
    one.network("a").say("7", model::Join{});
    one.network("a").say("7", model::KeepAlive{});
    if (i == 0) one.network("a").say("7", model::Unreachable{"no answer"});
  }
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(5));
  EXPECT_EQ(one.heard[2].kind(), MessageKind::kUnreachable);
  EXPECT_EQ(one.heard[4].kind(), MessageKind::kKeepAlive);
}

TEST_F(LocalGateway, AJoinAfterALeaveIsKeptAlsoWhenManyReadingsWereDroppedBetween) {
  one.listen(MessageKind::kJoin);
  one.listen(MessageKind::kLeave);
  one.network("a").say("7", model::Join{});
  one.network("a").say("7", model::Leave{});
  for (std::int64_t i = 0; i < 3000; ++i) one.network("a").say("8", reading(i));
  one.network("a").say("7", model::Join{});
  time.run_ready();
  ASSERT_THAT(one.heard, SizeIs(3));
  EXPECT_EQ(one.heard[2].kind(), MessageKind::kJoin);
}

TEST_F(LocalGateway, ListenersMayComeGoAndSendWhileTheyAreCalled) {
  std::string heard;
  std::optional<Handle> first;
  Handle third;
  first = one.gateway.subscribe(MessageKind::kKeepAlive, [&](const Message&) {
    heard += "1";
    first.reset();
    third = one.gateway.subscribe(MessageKind::kKeepAlive, [&](const Message&) { heard += "3"; });
    one.send(one.address("a", "7"), model::Actuate{5, kLamp, true});
  });
  auto second = one.gateway.subscribe(MessageKind::kKeepAlive, [&](const Message&) { heard += "2"; });
  one.network("a").say("7", model::KeepAlive{});
  time.run_ready();
  EXPECT_EQ(heard, "12");
  EXPECT_THAT(one.network("a").sent, SizeIs(1));
  one.network("a").say("7", model::KeepAlive{});
  time.run_ready();
  EXPECT_EQ(heard, "1223");
}

TEST_F(LocalGateway, AHandleMayOutliveTheGateway) {
  Handle handle;
  {
    Island four{4, time, ecology, log};
    handle = four.gateway.subscribe_user("note", [](const Message&) {});
  }
  handle.reset();
  EXPECT_FALSE(handle);
}

TEST_F(LocalGateway, SendsToTheNetworkInALaterTurnAndInOrder) {
  one.send(one.address("a", "7"), model::Actuate{1, kLamp, true});
  one.send(one.address("a", "7"), model::Actuate{2, kLamp, false});
  EXPECT_THAT(one.network("a").sent, IsEmpty());
  time.run_ready();
  ASSERT_THAT(one.network("a").sent, SizeIs(2));
  EXPECT_EQ(std::get<model::Actuate>(one.network("a").sent[1].body).request, 2u);
}

TEST_F(LocalGateway, TurnsTheNetworksErrorIntoAnAnswer) {
  const std::pair<ErrorCode, Outcome> expected[] = {{ErrorCode::kUnsupported, Outcome::kUnsupported},
                                                    {ErrorCode::kRefused, Outcome::kRefused},
                                                    {ErrorCode::kOutOfRange, Outcome::kRefused},
                                                    {ErrorCode::kNotFound, Outcome::kUndeliverable},
                                                    {ErrorCode::kBusy, Outcome::kBusy},
                                                    {ErrorCode::kIo, Outcome::kFailed}};
  for (const auto& [code, outcome] : expected) {
    one.heard.clear();
    one.network("a").why = {code, "because"};
    one.send(one.address("a", "7"), model::SetProperty{9, kLamp, true});
    time.run_ready();
    ASSERT_THAT(one.answers(), SizeIs(1));
    EXPECT_EQ(one.answers()[0].request, 9u);
    EXPECT_EQ(one.answers()[0].outcome, outcome);
    EXPECT_EQ(one.answers()[0].text, "because");
    EXPECT_EQ(one.heard[0].source, one.address("a", "7"));
  }
}

TEST_F(LocalGateway, AnswersThatThereIsNoSuchNetwork) {
  one.send(one.address("c", "7"), model::Actuate{9, kLamp, true});
  time.run_ready();
  ASSERT_THAT(one.answers(), SizeIs(1));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
  EXPECT_THAT(one.answers()[0].text, HasSubstr("no network c"));
  EXPECT_TRUE(log.contains("undeliverable from 1 to 1/c/7: no network c")) << "the counter grew: this names the cause";
}

TEST_F(LocalGateway, RefusesCommandsBeyondTheBoundWithBusy) {
  for (std::uint64_t i = 1; i <= 150; ++i) one.send(one.address("a", "7"), model::Actuate{i, kLamp, true});
  time.run_ready();
  EXPECT_THAT(one.network("a").sent, SizeIs(100));
  ASSERT_THAT(one.answers(), SizeIs(50));
  EXPECT_EQ(one.answers()[0].request, 101u);
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kBusy);
  EXPECT_EQ(one.gateway.counters().refused_busy, 50u);
}

TEST_F(LocalGateway, GivesUserMessagesToTheListenersOfTheirTypeAndAnswersWithoutOne) {
  std::vector<std::string> notes;
  auto handle = one.gateway.subscribe_user("note", [&](const Message& m) { notes.push_back(text_of(m)); });
  one.network("a").say("7", note("hello"));
  one.network("a").say("7", note("?", "question"));
  time.run_ready();
  EXPECT_THAT(notes, ElementsAre("hello"));
  ASSERT_THAT(one.heard, SizeIs(1));
  EXPECT_EQ(one.heard[0].destination, one.address("a", "7"));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
  EXPECT_THAT(one.answers()[0].text, HasSubstr("no listener"));
  handle.reset();
  one.network("a").say("7", note("late"));
  time.run_ready();
  EXPECT_THAT(notes, SizeIs(1));
  EXPECT_THAT(one.answers(), SizeIs(2));
}

TEST_F(LocalGateway, ReportsMayGoUnheard) {
  for (const auto& body : {model::Body(model::Join{}), model::Body(reading(1)), model::Body(model::Leave{}),
                           model::Body(model::State{}), model::Body(model::KeepAlive{})}) {
    two.network("a").say("7", body);
  }
  time.run_ready();
  EXPECT_THAT(two.heard, IsEmpty());
  EXPECT_EQ(two.gateway.counters().undeliverable, 0u);
}

TEST_F(LocalGateway, NeverAnswersAnAcknowledge) {
  one.send(one.address("nowhere", "7"), Acknowledge{1, Outcome::kSent, {}});
  one.send({OwnerId{99}, "", ""}, Acknowledge{2, Outcome::kSent, {}});
  time.run_for(1min);
  EXPECT_THAT(one.answers(), ElementsAre(::testing::Field(&Acknowledge::request, 1u)));
}

TEST_F(LocalGateway, DevicesOfTwoOwnNetworksTalkToEachOther) {
  one.network("a").say_to("7", one.address("b", "8"), note("hi"));
  time.run_ready();
  ASSERT_THAT(one.network("b").sent, SizeIs(1));
  EXPECT_EQ(text_of(one.network("b").sent[0]), "hi");
  EXPECT_EQ(one.network("b").sent[0].source, one.address("a", "7"));
}

TEST_F(LocalGateway, AMessageForADeviceGoesToTheNetworkThatHasIt) {
  one.gateway.set_device_lookup([](const std::string& device) {
    return device == "7" ? std::vector<std::string>{"b"} : std::vector<std::string>{};
  });
  two.send({one.space.self(), "", "7"}, Opaque{"chat", {'x'}});
  time.run_ready();
  ASSERT_THAT(one.network("b").sent, SizeIs(1));
  EXPECT_EQ(one.network("b").sent[0].destination.network, "b");
  EXPECT_THAT(one.network("a").sent, IsEmpty());
}

TEST_F(LocalGateway, AMessageForADeviceThatSeveralNetworksHaveIsRefusedWithTheirNames) {
  one.gateway.set_device_lookup([](const std::string&) { return std::vector<std::string>{"a", "b"}; });
  one.send({one.space.self(), "", "7"}, model::Actuate{5, kLamp, 1.0});
  time.run_ready();
  EXPECT_THAT(one.network("a").sent, IsEmpty());
  ASSERT_THAT(one.answers(), SizeIs(1));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kRefused);
  EXPECT_EQ(one.answers()[0].text, "device '7' is in 2 networks of island 1 (a, b): name one");
}

TEST_F(LocalGateway, AMessageForAnUnknownDeviceIsAnswered) {
  one.gateway.set_device_lookup([](const std::string&) { return std::vector<std::string>{}; });
  one.send({one.space.self(), "", "7"}, Opaque{"chat", {'x'}});
  time.run_ready();
  ASSERT_THAT(one.answers(), SizeIs(1));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
}

}  // namespace
}  // namespace rubicon::gateway
