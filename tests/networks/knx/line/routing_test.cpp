#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/line/router.h"

namespace rubicon::networks::knx::line {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(RoutingOverMemory, ATelegramLeavesAsAnIndicationFromOurAddress) {
  Router router(time, here);
  open(router);
  ASSERT_THAT(router.states, SizeIs(1));
  EXPECT_EQ(router.states[0].phase, LineState::Phase::kUp);
  EXPECT_EQ(router.states[0].server, "224.0.23.12:3671 on 10.77.0.2");
  EXPECT_EQ(to_string(router.states[0].own), "15.15.250");
  router.send(write_to(0x0a07));
  EXPECT_THAT(router.outcomes, IsEmpty()) << "never from inside the call";
  time.run_for(1ms);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent));
  EXPECT_THAT(other.received,
              ElementsAre(std::pair(Endpoint{"10.77.0.2", 49152}, "0610053000132900bce0fffa0a070300800c33")));
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900bce0fffa0a070300800c33", true)));
}

TEST_F(RoutingOverMemory, FramesOfKnxdAreReceived) {
  Router router(time, here);
  open(router);
  from_other("0610053000132900bcd011c80a070300800c33");  // of knx.md, section 18
  ASSERT_THAT(router.received, SizeIs(1));
  auto expected = write_to(0x0a07);
  expected.source = wire::IndividualAddress(0x11c8);
  expected.hops = 5;
  EXPECT_EQ(router.received[0], expected);
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900bcd011c80a070300800c33", false)));
}

TEST_F(RoutingOverMemory, FramesAreSentTwentyMillisecondsApart) {
  Router router(time, here);
  open(router);
  for (std::uint16_t i = 1; i <= 100; ++i) router.send(write_to(i), 1min);
  time.run_for(1s - 1ms);
  EXPECT_EQ(router.outcomes.size(), 50u);
  time.run_for(10s);
  EXPECT_THAT(router.outcomes, SizeIs(100));
  EXPECT_THAT(router.outcomes, Each(SendOutcome::kSent));
  EXPECT_THAT(pauses(router), Each(Duration(20ms)));
  ASSERT_THAT(other.received, SizeIs(100));
  EXPECT_THAT(other.received[99].second, HasSubstr("fffa0064")) << "in order";
}

TEST_F(RoutingOverMemory, AfterSilenceThereIsNoBurst) {
  Router router(time, here);
  open(router);
  time.run_for(1h);
  for (std::uint16_t i = 1; i <= 5; ++i) router.send(write_to(i));
  time.run_for(1s);
  EXPECT_THAT(pauses(router), Each(Duration(20ms)));
}

TEST_F(RoutingOverMemory, UrgentTelegramsAreSentFirst) {
  Router router(time, here);
  open(router);
  for (const auto priority :
       {wire::Priority::kLow, wire::Priority::kNormal, wire::Priority::kUrgent, wire::Priority::kSystem}) {
    auto telegram = write_to(0x0100 + static_cast<std::uint16_t>(priority));
    telegram.priority = priority;
    router.send(telegram);
  }
  time.run_for(1s);
  ASSERT_THAT(other.received, SizeIs(4));
  std::vector<std::string> order;
  for (const auto& [from, hex] : other.received) order.push_back(hex.substr(24, 4));
  EXPECT_THAT(order, ElementsAre("0100", "0102", "0101", "0103"));
}

TEST_F(RoutingOverMemory, OwnFramesAreIgnoredAndThoseOfOtherProgramsOfTheHostAreReceived) {
  Router router(time, here), neighbour(time, here);  // the same address and machine
  open(router);
  open(neighbour);
  router.send(write_to(1));
  time.run_for(100ms);
  neighbour.send(write_to(2));
  time.run_for(100ms);
  ASSERT_THAT(router.received, SizeIs(1));
  EXPECT_EQ(router.received[0].destination, wire::GroupAddress(2));
  ASSERT_THAT(neighbour.received, SizeIs(1));
  EXPECT_EQ(neighbour.received[0].destination, wire::GroupAddress(1));
  EXPECT_EQ(router.line->counters().at("own-frames"), 1u);
  EXPECT_EQ(router.line->counters().at("doubled-address"), 1u);
  EXPECT_THAT(router.line->state().reason, HasSubstr("15.15.250 is also the address of 10.77.0.2:49153"));
  EXPECT_THAT(router.states, SizeIs(2)) << "reported once";
}

TEST_F(RoutingOverMemory, EqualFramesOfOthersAreReceived) {
  Router router(time, here);
  open(router);
  router.send(write_to(0x0a07));
  time.run_for(100ms);
  from_other(other.received[0].second);
  EXPECT_THAT(router.received, SizeIs(1)) << "the same bytes from another endpoint";
}

TEST_F(RoutingOverMemory, WithoutAKnownEndpointOwnFramesAreRecognisedByTheirBytesOnce) {
  RoutingOptions options;
  options.interface_address = "any";
  Router router(time, here, options);
  open(router);
  EXPECT_EQ(router.line->state().server, "224.0.23.12:3671");
  for (std::uint16_t i = 1; i <= 30; ++i) router.send(write_to(i));
  time.run_for(1s);
  EXPECT_THAT(router.received, IsEmpty());
  EXPECT_EQ(router.line->counters().at("own-frames"), 30u);
  const auto last = other.received.back().second;
  other.listen({}, 49152);  // the port we have on our machine
  from_other(last);
  EXPECT_THAT(router.received, SizeIs(1));
}

TEST_F(RoutingOverMemory, OnlyTheLastTwentySentFramesAreKept) {
  RoutingOptions options;
  options.interface_address = "any";
  Router router(time, here, options);
  open(router);
  net.loses = [](const auto&) { return true; };
  for (std::uint16_t i = 1; i <= 21; ++i) router.send(write_to(i));
  time.run_for(1s);
  net.loses = nullptr;
  other.listen({}, 49152);  // the port we have on our machine
  from_other("0610053000132900bce0fffa00010300800c33");
  EXPECT_THAT(router.received, SizeIs(1));
  from_other("0610053000132900bce0fffa00020300800c33");
  EXPECT_THAT(router.received, SizeIs(1));
}

TEST_F(RoutingOverMemory, ABusyRouterStopsUsForItsTimeAndARandomPart) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RoutingOptions options;
    options.seed = seed;
    Router router(time, here, options);
    open(router);
    busy();
    const auto begun = time.now();
    router.send(write_to(1));
    time.run_for(5s);
    ASSERT_THAT(router.times, SizeIs(1));
    EXPECT_GE(router.times[0] - begun, 98ms);
    EXPECT_LE(router.times[0] - begun, 151ms);
    EXPECT_EQ(router.line->counters().at("busy"), 1u);
  }
}

TEST_F(RoutingOverMemory, ABusyRouterIsNamedInTheStateUntilSendingResumes) {
  Router router(time, here);
  open(router);
  busy();
  busy();
  EXPECT_EQ(router.line->state().reason, "10.77.0.3:3671 is busy: sending is paused");
  EXPECT_EQ(router.line->state().phase, LineState::Phase::kUp);
  time.run_for(1s);
  EXPECT_EQ(router.line->state().reason, "");
  EXPECT_THAT(router.states, SizeIs(3)) << "up, busy, and up again";
}

TEST_F(RoutingOverMemory, AfterAPauseFramesAreSentMoreSlowlyForAWhile) {
  Router router(time, here);
  open(router);
  for (std::uint16_t i = 1; i <= 20; ++i) router.send(write_to(i));
  busy();
  time.run_for(5s);
  const auto all = pauses(router);
  ASSERT_THAT(all, SizeIs(19));
  EXPECT_GE(all[0], 98ms) << "the first one was out before";
  EXPECT_EQ(all[1], 40ms);
  EXPECT_EQ(all[2], 40ms);
  EXPECT_EQ(all[18], 20ms);
}

TEST_F(RoutingOverMemory, ABusyForSingleDevicesIsObeyedToo) {
  Router router(time, here);
  open(router);
  busy("03e8", "0001");
  router.send(write_to(1));
  time.run_for(900ms);
  EXPECT_THAT(router.outcomes, IsEmpty());
  time.run_for(200ms);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent));
}

TEST_F(RoutingOverMemory, TelegramsWithAShorterLifetimeThanThePauseExpire) {
  Router router(time, here);
  open(router);
  busy("03e8");
  router.send(write_to(1), 500ms);
  router.send(write_to(2), 5s);
  time.run_for(5s);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kExpired, SendOutcome::kSent));
  EXPECT_THAT(other.received, SizeIs(2)) << "its own busy and one write";
}

TEST_F(RoutingOverMemory, LostMessagesAreCountedAndReported) {
  Router router(time, here);
  open(router);
  from_other("06100531000a04000005");
  from_other("06100531000a04010003");
  EXPECT_EQ(router.line->counters().at("lost-messages"), 8u);
  EXPECT_THAT(router.losses, ElementsAre(std::pair("10.77.0.3", 5), std::pair("10.77.0.3", 3)));
  ASSERT_THAT(router.notes, SizeIs(2));
  EXPECT_EQ(router.notes[1],
            std::pair(std::string("lost-messages"), std::string("10.77.0.3:3671 lost 3 telegrams (device state 01)")));
}

TEST_F(RoutingOverMemory, UnexpectedFramesAreNoted) {
  Router router(time, here);
  open(router);
  from_other("061005380006");
  from_other("06200530000629");
  ASSERT_THAT(router.notes, SizeIs(2));
  EXPECT_EQ(router.notes[0].first, "unknown-services");
  EXPECT_EQ(router.notes[0].second, "10.77.0.3:3671 sent service 0538: ignored");
  EXPECT_EQ(router.notes[1].first, "bad-frames");
  EXPECT_THAT(router.notes[1].second, HasSubstr("version 20"));
}

TEST_F(RoutingOverMemory, CountersHaveTheNamesOfThoseOfTunnels) {
  Router router(time, here);
  const auto counters = router.line->counters();
  for (const auto* name : {"telegrams-sent", "telegrams-received", "telegrams-waiting", "telegrams-refused",
                           "telegrams-expired", "telegrams-lost"})
    EXPECT_TRUE(counters.contains(name)) << name;
}

TEST_F(RoutingOverMemory, SearchesArePassedOn) {
  Router router(time, here);
  open(router);
  const std::string search = "06100201000e08010a4d00019ca4";
  from_other(search);
  EXPECT_THAT(router.searches, ElementsAre(std::pair(Endpoint{"10.77.0.3", 3671}, search)));
  EXPECT_THAT(router.received, IsEmpty());
}

TEST_F(RoutingOverMemory, SystemBroadcastsAreForTheMonitorOnly) {
  Router router(time, here);
  open(router);
  from_other("0610053300132900ace0110100000300800c33");
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900ace0110100000300800c33", false)));
  EXPECT_THAT(router.received, IsEmpty());
}

TEST_F(RoutingOverMemory, WithAnotherGroupOnlySystemBroadcastsAreReceivedOnTheSystemGroup) {
  RoutingOptions options;
  options.group.address = "239.1.2.3";
  Router router(time, here, options);
  open(router);
  const std::string broadcast = "0610053300132900ace0110100000300800c33";
  const std::string routed = "0610053000132900bcd011c80a070300800c33";
  const auto send = [&](const std::string& group, const std::string& hex) {
    other.send({group, kKnxPort}, bytes(hex));
    time.run_for(1ms);
  };
  send("239.1.2.3", broadcast);
  send(kGroup, routed);
  send(kGroup, "06100532000c0600ffff0000");
  EXPECT_THAT(router.frames, IsEmpty());
  send(kGroup, broadcast);
  EXPECT_THAT(router.frames, SizeIs(1));
  send("239.1.2.3", routed);
  EXPECT_THAT(router.received, SizeIs(1));
  router.send(write_to(1));
  time.run_for(100ms);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent)) << "the busy was none of ours";
  EXPECT_EQ(net.sent().back().to.address, "239.1.2.3");
}

TEST_F(RoutingOverMemory, BrokenAndForeignFramesAreCountedAndHarmless) {
  Router router(time, here);
  open(router);
  for (const auto* hex :
       {"", "06", "0610053000132900bcd011c80a07030080", "06200530000629", "061005300007ff", "0610053000062900",
        "06100532000706", "061005380006", "0610095000080000", "0610053000132e00bcd011c80a070300800c33",
        "0610053000082900", "06100530001329ffbcd011c80a070300800c33"})
    from_other(hex);
  EXPECT_THAT(router.received, IsEmpty());
  const auto counters = router.line->counters();
  EXPECT_EQ(counters.at("bad-frames") + counters.at("other-frames"), 12u);
  EXPECT_GE(counters.at("other-frames"), 3u);
  from_other("0610053000132900bcd011c80a070300800c33");
  EXPECT_THAT(router.received, SizeIs(1));
}

TEST_F(RoutingOverMemory, ATelegramTooLongForAFrameIsRefusedAndTheNextOneSent) {
  Router router(time, here);
  open(router);
  router.send(write_to(1, Bytes(300)));
  router.send(write_to(2));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kRefused, SendOutcome::kSent));
}

}  // namespace
}  // namespace rubicon::networks::knx::line
