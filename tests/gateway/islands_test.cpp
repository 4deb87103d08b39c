#include "gateway/islands.h"
#include "gateway/gateway_tuple.h"
#include "model/message.h"

namespace rubicon::gateway {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using tuples::Reply;
using tuples::Verdict;

class BetweenIslands : public Islands {
 protected:
  /// Sends bytes to island one as a component without a gateway.
  Reply post(const Bytes& bytes, std::string_view media_type = model::kMessageMediaType,
             std::string_view key = "GATEWAY") {
    Reply answer;
    bool answered = false;
    tuples::SetOptions options;
    options.media_type = media_type;
    robot.set_remote(
        OwnerId{1}, key, base::as_text(bytes), 0s,
        [&](const Reply& reply) {
          answer = reply;
          answered = true;
        },
        options);
    time.run_for(10s);
    EXPECT_TRUE(answered);
    return answer;
  }
  /// Makes an island forward all messages, unchanged, to the next one.
  void forward(Island& from, Island& to) {
    from.handles.push_back(from.gateway.subscribe(MessageKind::kOpaque, [&](const Message& message) {
      from.heard.push_back(message);
      Message onward = message;
      onward.destination = to.address();
      from.gateway.send(std::move(onward));
    }));
  }

  std::unique_ptr<tuples::Link> robot_link = *ecology.join(OwnerId{70001});
  TupleSpace robot{OwnerId{70001}, time, *robot_link};
};

TEST_F(BetweenIslands, MessagesArriveOnceAndInOrder) {
  two.listen(MessageKind::kOpaque);
  for (int i = 0; i < 50; ++i) one.send(two.address(), note(std::to_string(i)));
  time.run_for(10s);
  ASSERT_THAT(two.heard, SizeIs(50));
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(text_of(two.heard[i]), std::to_string(i));
  EXPECT_EQ(two.heard[0].origin, OwnerId{1});
  EXPECT_EQ(two.heard[0].hops, 1);
  EXPECT_THAT(one.answers(), IsEmpty());
}

TEST_F(BetweenIslands, ADeviceSendsToADeviceOfAnotherIsland) {
  one.network("a").say_to("7", two.address("b", "8"), note("hi"));
  time.run_for(1s);
  ASSERT_THAT(two.network("b").sent, SizeIs(1));
  EXPECT_EQ(two.network("b").sent[0].source, one.address("a", "7"));
  EXPECT_EQ(text_of(two.network("b").sent[0]), "hi");
}

TEST_F(BetweenIslands, AnUndeliverableMessageOfADeviceIsAnsweredOnItsOwnIsland) {
  one.network("a").say_to("7", two.address("nowhere", "8"), note("hi"));
  time.run_for(1s);
  ASSERT_THAT(one.heard, SizeIs(1));
  EXPECT_EQ(one.heard[0].destination, one.address("a", "7"));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
  EXPECT_THAT(one.answers()[0].text, HasSubstr("no network nowhere on island 2"));
  EXPECT_THAT(one.network("a").sent, IsEmpty());
}

TEST_F(BetweenIslands, ACommandOfAnotherIslandGoesToTheCommandHandlerNotToTheNetwork) {
  std::vector<Message> taken;
  two.gateway.set_command_handler([&](const Message& message, const std::string&) -> Result<void> {
    taken.push_back(message);
    return {};
  });
  one.send(two.address("a", "7"), model::Actuate{5, kLamp, true});
  one.send(two.address("a", "7"), model::SetProperty{6, kLamp, true});
  two.network("b").say_to("8", two.address("a", "7"), model::Actuate{7, kLamp, true});
  time.run_for(1s);
  ASSERT_THAT(taken, SizeIs(3));
  std::vector<std::uint64_t> requests;
  for (const auto& message : taken) requests.push_back(answerable_number(message));
  EXPECT_THAT(requests, ::testing::UnorderedElementsAre(5u, 6u, 7u));
  EXPECT_THAT(two.network("a").sent, IsEmpty());
}

TEST_F(BetweenIslands, ACommandThatCannotBeTakenIsAnsweredToItsIslandWithItsOwnRequestNumber) {
  two.gateway.set_command_handler(
      [](const Message&, const std::string&) { return fail(ErrorCode::kUnsupported, "no lamps here"); });
  one.send(two.address("a", "7"), model::Actuate{6, kLamp, true});
  time.run_for(1s);
  EXPECT_THAT(one.answers(), ElementsAre(::testing::FieldsAre(6u, Outcome::kUnsupported, "no lamps here")));
}

TEST_F(BetweenIslands, NetworksTakeApplicationMessagesOfOthersAndNothingElse) {
  const model::Body refused[] = {model::Join{},
                                 model::KeepAlive{},
                                 model::Leave{},
                                 reading(1),
                                 model::Sample{1, {kMeter}, 1s},
                                 model::State{},
                                 model::Probe{},
                                 model::Unreachable{},
                                 model::Actuate{2, kLamp, true},
                                 model::SetProperty{3, kLamp, true}};
  for (const auto& body : refused) {
    one.send(two.address("a", "7"), body);
    two.network("b").say_to("8", two.address("a", "7"), body);
  }
  time.run_for(1s);
  EXPECT_THAT(two.network("a").sent, IsEmpty());
  EXPECT_EQ(one.answers().size() + two.answers().size(), 2 * std::size(refused));
  for (const auto& answer : one.answers()) EXPECT_EQ(answer.outcome, Outcome::kRefused) << answer.text;
  one.send(two.address("a", "7"), note("hello"));
  time.run_for(1s);
  EXPECT_THAT(two.network("a").sent, SizeIs(1));
}

TEST_F(BetweenIslands, AMessageInTheNameOfAnotherIsRefusedCountedAndLoggedOnce) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.destination = one.address();
  message.body = note("hello");
  message.number = 5;
  auto origin = message, source = message, hops = message;
  origin.origin = OwnerId{2};
  source.source = two.address("a", "7");
  hops.origin = OwnerId{2};
  hops.hops = 1;
  for (const auto& forged : {origin, source, hops}) {
    const auto reply = post(model::to_cbor(forged));
    EXPECT_EQ(reply.verdict, Verdict::kRefused);
    EXPECT_THAT(reply.text, HasSubstr("but component 70001 posted it"));
  }
  EXPECT_THAT(one.heard, IsEmpty());
  EXPECT_EQ(one.gateway.counters().forged, 3u);
  EXPECT_EQ(
      std::count_if(log.lines.begin(), log.lines.end(),
                    [](const auto& line) { return line.find("refused a message of component 70001") != line.npos; }),
      1);
}

TEST_F(BetweenIslands, TheNumbersOfAnotherCannotBeUsedUp) {
  two.listen(MessageKind::kOpaque);
  const auto number = one.gateway.send(Message{{}, 0, 0, {}, one.address(), note("first")});
  Message forged;
  forged.origin = OwnerId{1};
  forged.destination = two.address();
  forged.body = note("forged");
  for (std::uint64_t next = 1; next <= 10; ++next) {
    forged.number = number + next;
    robot.set_remote(OwnerId{2}, "GATEWAY", base::as_text(model::to_cbor(forged)), 0s, [](const Reply&) {},
                     {.media_type = model::kMessageMediaType});
  }
  time.run_for(1s);
  one.send(two.address(), note("true"));
  time.run_for(1s);
  EXPECT_THAT(texts_of(two.heard_of(MessageKind::kOpaque)), ElementsAre("true"));
  EXPECT_EQ(two.gateway.counters().forged, 10u);
}

TEST_F(BetweenIslands, AnUnreachableIslandIsAnsweredWithTheReason) {
  one.send({OwnerId{99}, "a", "7"}, model::Actuate{5, kLamp, true});
  ecology.cut(OwnerId{1}, OwnerId{2});
  one.send(two.address("a", "7"), model::Actuate{6, kLamp, true});
  time.run_for(10s);
  ASSERT_THAT(one.answers(), SizeIs(2));
  EXPECT_EQ(one.answers()[0].request, 5u);
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
  EXPECT_THAT(one.answers()[0].text, HasSubstr("island 99"));
  EXPECT_EQ(one.answers()[1].request, 6u);
  EXPECT_THAT(two.network("a").sent, IsEmpty());
}

TEST_F(BetweenIslands, AMessageLostOnTheWayIsAnsweredWhenItsTimeEnds) {
  one.send(two.address("a", "7"), model::Actuate{6, kLamp, true});
  time.post([&] { ecology.cut(OwnerId{1}, OwnerId{2}); });
  time.run_for(10s);
  ASSERT_THAT(one.answers(), SizeIs(1));
  EXPECT_EQ(one.answers()[0].outcome, Outcome::kUndeliverable);
}

TEST_F(BetweenIslands, InARingThatForwardsEverythingEachMessageArrivesOnce) {
  forward(one, two);
  forward(two, three);
  forward(three, one);
  one.send(two.address(), note("from one"));
  three.network("a").say_to("7", one.address(), note("from three"));
  time.run_for(1min);
  EXPECT_THAT(texts_of(one.heard_of(MessageKind::kOpaque)), ElementsAre("from three"));
  EXPECT_THAT(texts_of(two.heard_of(MessageKind::kOpaque)), ::testing::UnorderedElementsAre("from one", "from three"));
  EXPECT_THAT(texts_of(three.heard_of(MessageKind::kOpaque)), ElementsAre("from one"));
  EXPECT_EQ(one.gateway.counters().looped + three.gateway.counters().looped, 2u);
}

TEST_F(BetweenIslands, TheSameMessageOnTwoWaysArrivesOnce) {
  three.listen(MessageKind::kOpaque);
  two.handles.push_back(two.gateway.subscribe(MessageKind::kOpaque, [&](const Message& message) {
    Message onward = message;
    onward.destination = three.address();
    two.gateway.send(Message(onward));
    two.gateway.send(std::move(onward));
  }));
  one.send(two.address(), note("hello"));
  time.run_for(1s);
  EXPECT_THAT(three.heard, SizeIs(1));
  EXPECT_EQ(three.heard[0].hops, 2);
  EXPECT_EQ(three.gateway.counters().duplicates, 1u);
  EXPECT_THAT(one.answers(), IsEmpty());
}

TEST_F(BetweenIslands, AMessageThatEnteredTooManyIslandsIsAnsweredToItsSource) {
  Message old;
  old.origin = OwnerId{2};
  old.number = 77;
  old.hops = model::kMaxHops;
  old.source = two.address("a", "7");
  old.destination = three.address();
  old.body = note("tired");
  three.listen(MessageKind::kOpaque);
  one.gateway.send(old);
  time.run_for(1s);
  EXPECT_THAT(three.heard, IsEmpty());
  EXPECT_EQ(three.gateway.counters().looped, 1u);
  ASSERT_THAT(two.answers(), SizeIs(1));
  EXPECT_EQ(two.answers()[0].request, 77u);
  EXPECT_THAT(two.answers()[0].text, HasSubstr("hop limit"));
}

TEST_F(BetweenIslands, AFloodedIslandAnswersBusyAndLosesNothing) {
  two.listen(MessageKind::kOpaque);
  for (Island* island : {&one, &three}) {
    for (int i = 0; i < 100; ++i) island->send(two.address(), note("x"));
  }
  time.run_for(10s);
  const auto refused = one.answers().size() + three.answers().size();
  EXPECT_EQ(two.heard_of(MessageKind::kOpaque).size() + refused, 200u);
  EXPECT_GT(refused, 0u);
  for (const auto& answer : three.answers()) EXPECT_EQ(answer.outcome, Outcome::kBusy);
}

TEST_F(BetweenIslands, WhatWasTakenFreesItsRoomForTheNextMessages) {
  two.listen(MessageKind::kOpaque);
  const std::string large(200 * 1024, 'x');  // a hundred of them are more than may wait at once
  for (int i = 0; i < 150; ++i) {
    one.send(two.address(), note(i < 100 ? large : "small"));
    time.run_for(1s);
  }
  EXPECT_THAT(two.heard, SizeIs(150));
  EXPECT_THAT(one.answers(), IsEmpty());
}

TEST_F(BetweenIslands, AMessageThatFoundNoRoomMayComeAgain) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.origin = OwnerId{70001};
  message.destination = one.address();
  message.body = note("hello");
  for (message.number = 1; message.number <= 101; ++message.number) {
    robot.set_remote(OwnerId{1}, "GATEWAY", base::as_text(model::to_cbor(message)), 0s, [](const Reply&) {},
                     {.media_type = model::kMessageMediaType});
  }
  time.run_for(1s);
  ASSERT_THAT(one.heard, SizeIs(100));
  message.number = 101;
  EXPECT_EQ(post(model::to_cbor(message)).verdict, Verdict::kApplied);
  EXPECT_THAT(one.heard, SizeIs(101));
  EXPECT_EQ(one.gateway.counters().duplicates, 0u);
}

TEST_F(BetweenIslands, RefusesWhatIsNoMessageAndCountsIt) {
  const auto wrong_type = post(model::to_cbor(Message{}), "text/plain");
  EXPECT_EQ(wrong_type.verdict, Verdict::kRefused);
  EXPECT_THAT(wrong_type.text, HasSubstr("text/plain"));
  const auto garbage = post({0xff, 0x00, 0x13});
  EXPECT_EQ(garbage.verdict, Verdict::kRefused);
  EXPECT_FALSE(garbage.text.empty());
  EXPECT_EQ(post({}).verdict, Verdict::kRefused);
  EXPECT_EQ(one.gateway.counters().malformed, 3u);
}

TEST_F(BetweenIslands, TheKeysOfTheOriginalAreAcceptedTooAndKeepNoValue) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.destination = one.address();
  message.body = note("hello");
  for (const auto* key : {"RUBICON_GATEWAY", "RUBICON_GATEWAY.7"}) {
    EXPECT_EQ(post(model::to_cbor(message), "application/rubicon", key).verdict, Verdict::kApplied) << key;
    EXPECT_FALSE(one.space.get(OwnerId{1}, key)) << key;
  }
  EXPECT_THAT(one.heard, SizeIs(2));
}

TEST_F(BetweenIslands, JavaSerialisationIsUnsupportedCountedAndLogged) {
  const auto reply = post({0xac, 0xed, 0x00, 0x05, 0x73, 0x72}, "application/rubicon", "RUBICON_GATEWAY.46");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, ErrorCode::kUnsupported);
  EXPECT_THAT(reply.text, HasSubstr("Java serialisation"));
  EXPECT_EQ(one.gateway.counters().malformed, 1u);
  EXPECT_TRUE(log.contains("component 70001: messages in Java serialisation"));
}

TEST_F(BetweenIslands, TheGatewayTupleKeepsNoValue) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.origin = OwnerId{70001};
  message.number = 5;
  message.destination = one.address();
  message.body = note("hello");
  EXPECT_EQ(post(model::to_cbor(message)).verdict, Verdict::kApplied);
  EXPECT_THAT(one.heard, SizeIs(1));
  EXPECT_EQ(one.space.get(OwnerId{1}, "GATEWAY")->value, "");
}

TEST_F(BetweenIslands, TheMediaTypesOfD14AndOfTheOriginalAreTakenToo) {
  one.listen(MessageKind::kOpaque);
  std::size_t posted = 0;
  for (const auto* media_type : {"application/rubicon+cbor", "rubicon/application", "application/rubicon"}) {
    Message message;
    message.destination = one.address();
    message.body = note(media_type);
    EXPECT_EQ(post(model::to_cbor(message), media_type).verdict, Verdict::kApplied) << media_type;
    EXPECT_THAT(one.heard, SizeIs(++posted)) << media_type;
  }
  EXPECT_EQ(one.gateway.counters().malformed, 0u);
}

TEST_F(BetweenIslands, AMessageWithoutASourceGetsItsSenderAsSource) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.body = note("hello");
  EXPECT_EQ(post(model::to_cbor(message)).verdict, Verdict::kApplied);
  ASSERT_THAT(one.heard, SizeIs(1));
  EXPECT_EQ(one.heard[0].source.island, OwnerId{70001});
  EXPECT_EQ(one.heard[0].origin, OwnerId{70001});
  EXPECT_EQ(one.heard[0].destination.island, OwnerId{1});
}

TEST_F(BetweenIslands, NothingIsAppendedToTheGatewayTuple) {
  one.listen(MessageKind::kOpaque);
  Message message;
  message.body = note("hello");
  const auto bytes = model::to_cbor(message);
  for (const auto media_type : {model::kMessageMediaType, std::string_view("text/plain"), std::string_view()}) {
    Reply reply;
    robot.append_remote(OwnerId{1}, "GATEWAY", base::as_text(bytes), 1s, [&](const Reply& answer) { reply = answer; },
                        {.media_type = media_type});
    time.run_for(1s);
    EXPECT_EQ(reply.verdict, Verdict::kRefused);
    EXPECT_EQ(reply.code, ErrorCode::kRefused);
    EXPECT_THAT(reply.text, HasSubstr("GATEWAY accepts whole values only"));
  }
  EXPECT_THAT(one.heard, IsEmpty());
  EXPECT_EQ(one.space.get(OwnerId{1}, "GATEWAY")->value, "");
}

TEST_F(BetweenIslands, AMessageOnItsWayThroughIsHandedOn) {
  three.listen(MessageKind::kOpaque);
  Message message;
  message.origin = OwnerId{70001};
  message.number = 5;
  message.source = {OwnerId{70001}, "a", "7"};
  message.destination = three.address();
  message.body = note("through one");
  EXPECT_EQ(post(model::to_cbor(message)).verdict, Verdict::kApplied);
  ASSERT_THAT(three.heard, SizeIs(1));
  EXPECT_EQ(three.heard[0].hops, 2);
  EXPECT_EQ(three.heard[0].origin, OwnerId{70001});
  EXPECT_EQ(three.heard[0].source, (Address{OwnerId{70001}, "a", "7"}));
}

}  // namespace
}  // namespace rubicon::gateway
