#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "knx_routing/host.h"
#include "networks/knx/line/routing_line.h"

namespace rubicon::networks::knx {
namespace {

using namespace std::chrono_literals;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::string kGroup(kKnxGroup);

Telegram write_to(std::uint16_t group, Bytes value = {0x0c, 0x33}) {
  Telegram telegram;
  telegram.destination = GroupAddress(group);
  telegram.payload = {std::move(value), false};
  return telegram;
}

/// A routing line of a host, and all it says.
struct Router {
  Router(VirtualScheduler& t, Host& host, RoutingOptions options = {}) : time(t) {
    LineCalls calls;
    calls.changed = [this](const LineState& state) { states.push_back(state); };
    calls.failed = [this](Error error) { failures.push_back(std::move(error)); };
    calls.received = [this](const Telegram& telegram) { heard.push_back(telegram); };
    calls.frame = [this](ByteView cemi, bool outgoing) { frames.emplace_back(base::to_hex(cemi), outgoing); };
    RoutingCalls more;
    more.lost = [this](const Endpoint& from, const RoutingLostMessage& message) {
      losses.emplace_back(from.address, message.lost);
    };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.emplace_back(subject, std::string(text));
    };
    more.discovery = [this](const Endpoint& from, ByteView frame) { searches.emplace_back(from, base::to_hex(frame)); };
    if (options.interface_address.empty()) options.interface_address = host.at;
    if (options.interface_address == "any") options.interface_address.clear();
    line = std::make_unique<RoutingLine>(time, host.lines, std::move(options), std::move(calls), std::move(more));
  }
  void send(Telegram telegram, Duration lives = 5s) {
    line->send(std::move(telegram), time.now() + lives, [this](Sent outcome, std::string_view) {
      outcomes.push_back(outcome);
      times.push_back(time.now());
    });
  }

  VirtualScheduler& time;
  std::vector<LineState> states;
  std::vector<Error> failures;
  std::vector<Telegram> heard;
  std::vector<std::pair<std::string, bool>> frames;
  std::vector<std::pair<std::string, int>> losses;
  std::vector<std::pair<Endpoint, std::string>> searches;
  std::vector<std::pair<std::string, std::string>> notes;
  std::vector<Sent> outcomes;
  std::vector<SteadyTime> times;
  std::unique_ptr<RoutingLine> line;
};

class RoutingOverMemory : public ::testing::Test {
 protected:
  void SetUp() override { other.listen({kGroup}, kKnxPort); }
  void open(Router& router) {
    ASSERT_TRUE(router.line->open());
    time.run_for(1s);
  }
  void from_other(std::string_view hex) {
    other.send({kGroup, kKnxPort}, bytes(hex));
    time.run_for(1ms);
  }
  void busy(std::string_view wait = "0064", std::string_view control = "0000") {
    from_other("06100532000c0600" + std::string(wait) + std::string(control));
  }
  std::vector<Duration> pauses(const Router& router) {
    std::vector<Duration> all;
    for (std::size_t i = 1; i < router.times.size(); ++i) all.push_back(router.times[i] - router.times[i - 1]);
    return all;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  Host here{net, "10.77.0.2"}, other{net, "10.77.0.3"};
};

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
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kSent));
  EXPECT_THAT(other.heard,
              ElementsAre(std::pair(Endpoint{"10.77.0.2", 49152}, "0610053000132900bce0fffa0a070300800c33")));
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900bce0fffa0a070300800c33", true)));
}

TEST_F(RoutingOverMemory, WhatKnxdSendsIsHeard) {
  Router router(time, here);
  open(router);
  from_other("0610053000132900bcd011c80a070300800c33");  // of knx.md, section 18
  ASSERT_THAT(router.heard, SizeIs(1));
  auto expected = write_to(0x0a07);
  expected.source = IndividualAddress(0x11c8);
  expected.hops = 5;
  EXPECT_EQ(router.heard[0], expected);
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900bcd011c80a070300800c33", false)));
}

TEST_F(RoutingOverMemory, FramesStandTwentyMillisecondsApart) {
  Router router(time, here);
  open(router);
  for (std::uint16_t i = 1; i <= 100; ++i) router.send(write_to(i), 1min);
  time.run_for(1s - 1ms);
  EXPECT_EQ(router.outcomes.size(), 50u);
  time.run_for(10s);
  EXPECT_THAT(router.outcomes, SizeIs(100));
  EXPECT_THAT(router.outcomes, Each(Sent::kSent));
  EXPECT_THAT(pauses(router), Each(Duration(20ms)));
  ASSERT_THAT(other.heard, SizeIs(100));
  EXPECT_THAT(other.heard[99].second, HasSubstr("fffa0064")) << "in order";
}

TEST_F(RoutingOverMemory, AfterSilenceThereIsNoBurst) {
  Router router(time, here);
  open(router);
  time.run_for(1h);
  for (std::uint16_t i = 1; i <= 5; ++i) router.send(write_to(i));
  time.run_for(1s);
  EXPECT_THAT(pauses(router), Each(Duration(20ms)));
}

TEST_F(RoutingOverMemory, UrgentTelegramsOvertake) {
  Router router(time, here);
  open(router);
  for (const auto priority : {Priority::kLow, Priority::kNormal, Priority::kUrgent, Priority::kSystem}) {
    auto telegram = write_to(0x0100 + static_cast<std::uint16_t>(priority));
    telegram.priority = priority;
    router.send(telegram);
  }
  time.run_for(1s);
  ASSERT_THAT(other.heard, SizeIs(4));
  std::vector<std::string> order;
  for (const auto& [from, hex] : other.heard) order.push_back(hex.substr(24, 4));
  EXPECT_THAT(order, ElementsAre("0100", "0102", "0101", "0103"));
}

TEST_F(RoutingOverMemory, OwnFramesAreNotHeardAndThoseOfANeighbourOnThisMachineAre) {
  Router router(time, here), neighbour(time, here);  // the same address and machine
  open(router);
  open(neighbour);
  router.send(write_to(1));
  time.run_for(100ms);
  neighbour.send(write_to(2));
  time.run_for(100ms);
  ASSERT_THAT(router.heard, SizeIs(1));
  EXPECT_EQ(router.heard[0].destination, GroupAddress(2));
  ASSERT_THAT(neighbour.heard, SizeIs(1));
  EXPECT_EQ(neighbour.heard[0].destination, GroupAddress(1));
  EXPECT_EQ(router.line->counters().at("own-frames"), 1u);
  EXPECT_EQ(router.line->counters().at("doubled-address"), 1u);
  EXPECT_THAT(router.line->state().reason, HasSubstr("15.15.250 is the address of 10.77.0.2:49153 too"));
  EXPECT_THAT(router.states, SizeIs(2)) << "told once";
}

TEST_F(RoutingOverMemory, EqualFramesOfOthersAreHeard) {
  Router router(time, here);
  open(router);
  router.send(write_to(0x0a07));
  time.run_for(100ms);
  from_other(other.heard[0].second);
  EXPECT_THAT(router.heard, SizeIs(1)) << "the same bytes, but from somebody else's endpoint";
}

TEST_F(RoutingOverMemory, WhereTheOwnEndpointIsUnknownOwnFramesAreKnownByTheirBytesOnce) {
  RoutingOptions options;
  options.interface_address = "any";
  Router router(time, here, options);
  open(router);
  EXPECT_EQ(router.line->state().server, "224.0.23.12:3671");
  for (std::uint16_t i = 1; i <= 30; ++i) router.send(write_to(i));
  time.run_for(1s);
  EXPECT_THAT(router.heard, IsEmpty());
  EXPECT_EQ(router.line->counters().at("own-frames"), 30u);
  const auto last = other.heard.back().second;
  other.listen({}, 49152);  // the port we have on our machine
  from_other(last);
  EXPECT_THAT(router.heard, SizeIs(1));
}

TEST_F(RoutingOverMemory, OnlyTheLastTwentyThatDidNotComeBackAreKept) {
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
  EXPECT_THAT(router.heard, SizeIs(1));
  from_other("0610053000132900bce0fffa00020300800c33");
  EXPECT_THAT(router.heard, SizeIs(1));
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

TEST_F(RoutingOverMemory, ABusyRouterIsNamedInTheStateUntilWeGoOn) {
  Router router(time, here);
  open(router);
  busy();
  busy();
  EXPECT_EQ(router.line->state().reason, "10.77.0.3:3671 is busy: nothing is sent for now");
  EXPECT_EQ(router.line->state().phase, LineState::Phase::kUp);
  time.run_for(1s);
  EXPECT_EQ(router.line->state().reason, "");
  EXPECT_THAT(router.states, SizeIs(3)) << "up, busy, and up again";
}

TEST_F(RoutingOverMemory, AfterAPauseFramesStandFurtherApartForAWhile) {
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

TEST_F(RoutingOverMemory, ABusyThatIsMeantForSingleDevicesIsObeyedToo) {
  Router router(time, here);
  open(router);
  busy("03e8", "0001");
  router.send(write_to(1));
  time.run_for(900ms);
  EXPECT_THAT(router.outcomes, IsEmpty());
  time.run_for(200ms);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kSent));
}

TEST_F(RoutingOverMemory, WhatDoesNotLiveAsLongAsThePauseExpires) {
  Router router(time, here);
  open(router);
  busy("03e8");
  router.send(write_to(1), 500ms);
  router.send(write_to(2), 5s);
  time.run_for(5s);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kExpired, Sent::kSent));
  EXPECT_THAT(other.heard, SizeIs(2)) << "its own busy and one write";
}

TEST_F(RoutingOverMemory, LostMessagesAreCountedAndTold) {
  Router router(time, here);
  open(router);
  from_other("06100531000a04000005");
  from_other("06100531000a04010003");
  EXPECT_EQ(router.line->counters().at("lost-messages"), 8u);
  EXPECT_THAT(router.losses, ElementsAre(std::pair("10.77.0.3", 5), std::pair("10.77.0.3", 3)));
  ASSERT_THAT(router.notes, SizeIs(2));
  EXPECT_EQ(router.notes[1], std::pair(std::string("lost-messages"),
                                       std::string("10.77.0.3:3671 lost 3 telegrams on their way (device state 01)")));
}

TEST_F(RoutingOverMemory, OddFramesAreWorthANote) {
  Router router(time, here);
  open(router);
  from_other("061005380006");
  from_other("06200530000629");
  ASSERT_THAT(router.notes, SizeIs(2));
  EXPECT_EQ(router.notes[0].first, "unknown-services");
  EXPECT_EQ(router.notes[0].second, "10.77.0.3:3671 sent service 0538: passed over");
  EXPECT_EQ(router.notes[1].first, "bad-frames");
  EXPECT_THAT(router.notes[1].second, HasSubstr("version 20"));
}

TEST_F(RoutingOverMemory, CountersAreCalledAsThoseOfTunnels) {
  Router router(time, here);
  const auto counters = router.line->counters();
  for (const auto* name : {"telegrams-sent", "telegrams-received", "telegrams-waiting", "telegrams-refused",
                           "telegrams-expired", "telegrams-lost"})
    EXPECT_TRUE(counters.contains(name)) << name;
}

TEST_F(RoutingOverMemory, SearchesAreHandedOn) {
  Router router(time, here);
  open(router);
  const std::string search = "06100201000e08010a4d00019ca4";
  from_other(search);
  EXPECT_THAT(router.searches, ElementsAre(std::pair(Endpoint{"10.77.0.3", 3671}, search)));
  EXPECT_THAT(router.heard, IsEmpty());
}

TEST_F(RoutingOverMemory, SystemBroadcastsAreForTheMonitorOnly) {
  Router router(time, here);
  open(router);
  from_other("0610053300132900ace0110100000300800c33");
  EXPECT_THAT(router.frames, ElementsAre(std::pair("2900ace0110100000300800c33", false)));
  EXPECT_THAT(router.heard, IsEmpty());
}

TEST_F(RoutingOverMemory, ADifferentGroupHearsSystemBroadcastsOnTheSystemsGroupAndNothingElseThere) {
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
  EXPECT_THAT(router.heard, SizeIs(1));
  router.send(write_to(1));
  time.run_for(100ms);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kSent)) << "the busy was none of ours";
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
  EXPECT_THAT(router.heard, IsEmpty());
  const auto counters = router.line->counters();
  EXPECT_EQ(counters.at("bad-frames") + counters.at("other-frames"), 12u);
  EXPECT_GE(counters.at("other-frames"), 3u);
  from_other("0610053000132900bcd011c80a070300800c33");
  EXPECT_THAT(router.heard, SizeIs(1));
}

TEST_F(RoutingOverMemory, ATelegramThatNoFrameHoldsIsRefusedAndTheNextOneGoes) {
  Router router(time, here);
  open(router);
  router.send(write_to(1, Bytes(300)));
  router.send(write_to(2));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kRefused, Sent::kSent));
}

TEST_F(RoutingOverMemory, ALineWithoutRoomIsTriedAgain) {
  Router router(time, here);
  open(router);
  net.refuses = 3;
  router.send(write_to(1));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kSent));
  EXPECT_EQ(router.line->counters().at("send-retries"), 3u);
  EXPECT_THAT(other.heard, SizeIs(1));
}

TEST_F(RoutingOverMemory, ALostLineKeepsWhatWaitsForTheNext) {
  Router router(time, here);
  open(router);
  net.refuses = 50;
  router.send(write_to(1), 1min);
  router.send(write_to(2), 1min);
  router.send(write_to(3), 3s);
  time.run_for(2s);
  ASSERT_THAT(router.failures, SizeIs(1));
  EXPECT_EQ(router.states.back().phase, LineState::Phase::kOff);
  EXPECT_THAT(router.states.back().reason, HasSubstr("wait already"));
  EXPECT_EQ(net.open_sockets(), 1u) << "the other's";
  EXPECT_THAT(router.outcomes, IsEmpty());
  time.run_for(10s);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kExpired));
  ASSERT_TRUE(router.line->open());
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kExpired, Sent::kSent, Sent::kSent));
  EXPECT_THAT(other.heard, SizeIs(2));
  EXPECT_EQ(router.states.back().phase, LineState::Phase::kUp);
}

TEST_F(RoutingOverMemory, AnInterfaceThatIsNotThereIsNamed) {
  RoutingOptions options;
  options.interface_address = "192.0.2.1";
  Router router(time, here, options);
  const auto opened = router.line->open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().text, HasSubstr("192.0.2.1"));
  EXPECT_EQ(router.line->state().phase, LineState::Phase::kOff);
}

TEST_F(RoutingOverMemory, WhoHearsNobodyJoinsAgain) {
  Router router(time, here);
  open(router);
  for (int i = 0; i < 10; ++i) {
    time.run_for(50s);
    from_other("0610053000132900bcd011c80a070300800c33");
  }
  EXPECT_EQ(router.line->counters().at("joined-again"), 0u);
  for (int i = 0; i < 3; ++i) {
    router.send(write_to(1));
    time.run_for(50s);
  }
  EXPECT_EQ(router.line->counters().at("joined-again"), 2u) << "own frames prove nothing";
  EXPECT_EQ(net.open_sockets(), 3u);
  from_other("0610053000132900bcd011c80a070300800c33");
  EXPECT_THAT(router.heard, SizeIs(11));
}

TEST_F(RoutingOverMemory, AnInterfaceThatWentAwayIsNoticedThoughNothingIsSent) {
  Router router(time, here);
  open(router);
  net.gone_interfaces.insert("10.77.0.2");
  time.run_for(61s);
  ASSERT_THAT(router.failures, SizeIs(1));
  EXPECT_THAT(router.failures[0].text, HasSubstr("10.77.0.2"));
  time.run_for(1h);
  EXPECT_THAT(router.failures, SizeIs(1)) << "once, until it is opened again";
}

TEST_F(RoutingOverMemory, CallsMayBeEmpty) {
  RoutingLine line(time, here.lines, {}, {});
  ASSERT_TRUE(line.open());
  line.send(write_to(1), SteadyTime::max(), {});
  for (const auto* hex : {"0610053000132900bcd011c80a070300800c33", "06100531000a04000005", "061005380006", "0610",
                          "06100532000c0600006400000", "06100201000e08010a4d00019ca4"}) {
    const auto frame = base::from_hex(hex);
    if (frame) other.send({kGroup, kKnxPort}, *frame);
    time.run_for(1ms);
  }
  net.refuses = 50;
  line.send(write_to(1), SteadyTime::max(), {});
  time.run_for(10s);
  EXPECT_EQ(line.state().phase, LineState::Phase::kOff);
}

TEST_F(RoutingOverMemory, MayBeDestroyedInAnyOfItsCalls) {
  for (int when = 0; when < 10; ++when) {
    std::unique_ptr<RoutingLine> line;
    const auto destroy_if = [&](int now) {
      if (when == now) line.reset();
    };
    LineCalls calls;
    calls.changed = [&](const LineState& state) {
      destroy_if(state.phase == LineState::Phase::kOff ? 1 : state.reason.empty() ? 0 : 2);
    };
    calls.failed = [&](const Error&) { destroy_if(3); };
    calls.received = [&](const Telegram&) { destroy_if(4); };
    calls.frame = [&](ByteView, bool outgoing) { destroy_if(outgoing ? 5 : 6); };
    calls.note = [&](const std::string&, std::string_view) { destroy_if(7); };
    RoutingCalls more;
    more.lost = [&](const Endpoint&, const RoutingLostMessage&) { destroy_if(8); };
    more.discovery = [&](const Endpoint&, ByteView) { destroy_if(9); };
    RoutingOptions options;
    options.interface_address = here.at;
    line = std::make_unique<RoutingLine>(time, here.lines, options, std::move(calls), std::move(more));
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
    if (line) line->send(write_to(1), SteadyTime::max(), [](Sent, std::string_view) {});
    time.run_for(100ms);
    for (const auto* hex : {"06100201000e08010a4d00019ca4", "0610053000132900bcd011c80a070300800c33", "061005380006",
                            "06100531000a04000005", "06100532000c060000640000"}) {
      // Lost messages are noted before they are told.
      if (when == 8 && std::string_view(hex) == "061005380006") continue;
      from_other(hex);
    }
    time.run_for(1s);
    net.refuses = 50;
    if (line) line->send(write_to(1), SteadyTime::max(), [](Sent, std::string_view) {});
    time.run_for(5s);
    net.refuses = 0;
    EXPECT_EQ(line, nullptr) << when;
  }
  RoutingOptions options;
  options.interface_address = here.at;
  auto line = std::make_unique<RoutingLine>(time, here.lines, options, LineCalls{});
  ASSERT_TRUE(line->open());
  line->send(write_to(1), SteadyTime::max(), [&](Sent, std::string_view) { line.reset(); });
  time.run_for(1s);
  EXPECT_EQ(line, nullptr);
}

TEST_F(RoutingOverMemory, WhatWaitsBeforeTheLineIsThereGoesWhenItIs) {
  Router router(time, here);
  router.send(write_to(1));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, IsEmpty());
  open(router);
  EXPECT_THAT(router.outcomes, ElementsAre(Sent::kSent));
}

TEST_F(RoutingOverMemory, ADestroyedLineSaysNothingMore) {
  Router router(time, here);
  open(router);
  router.send(write_to(1));
  router.send(write_to(2));
  time.run_for(1ms);
  router.line.reset();
  other.send({kGroup, kKnxPort}, bytes("0610053000132900bcd011c80a070300800c33"));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, SizeIs(1));
  EXPECT_THAT(router.heard, IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::knx
