#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/line/router.h"

namespace rubicon::networks::knx::line {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class RoutingLineLife : public RoutingOverMemory {};

TEST_F(RoutingLineLife, ALineWithAFullQueueIsRetried) {
  Router router(time, here);
  open(router);
  net.refuses = 3;
  router.send(write_to(1));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent));
  EXPECT_EQ(router.line->counters().at("send-retries"), 3u);
  EXPECT_THAT(other.received, SizeIs(1));
}

TEST_F(RoutingLineLife, ALostLineKeepsWaitingTelegramsForTheNext) {
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
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kExpired));
  ASSERT_TRUE(router.line->open());
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kExpired, SendOutcome::kSent, SendOutcome::kSent));
  EXPECT_THAT(other.received, SizeIs(2));
  EXPECT_EQ(router.states.back().phase, LineState::Phase::kUp);
}

TEST_F(RoutingLineLife, AMissingInterfaceIsNamed) {
  RoutingOptions options;
  options.interface_address = "192.0.2.1";
  Router router(time, here, options);
  const auto opened = router.line->open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().text, HasSubstr("192.0.2.1"));
  EXPECT_EQ(router.line->state().phase, LineState::Phase::kOff);
}

TEST_F(RoutingLineLife, AfterSilenceTheGroupIsJoinedAgain) {
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
  EXPECT_THAT(router.received, SizeIs(11));
}

TEST_F(RoutingLineLife, ARemovedInterfaceIsDetectedWithoutTraffic) {
  Router router(time, here);
  open(router);
  net.gone_interfaces.insert("10.77.0.2");
  time.run_for(61s);
  ASSERT_THAT(router.failures, SizeIs(1));
  EXPECT_THAT(router.failures[0].text, HasSubstr("10.77.0.2"));
  time.run_for(1h);
  EXPECT_THAT(router.failures, SizeIs(1)) << "once, until it is opened again";
}

TEST_F(RoutingLineLife, CallsMayBeEmpty) {
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

TEST_F(RoutingLineLife, MayBeDestroyedInAnyOfItsCalls) {
  for (int when = 0; when < 10; ++when) {
    std::unique_ptr<RoutingLine> line;
    const auto destroy_if = [&](int now) {
      if (when == now) line.reset();
    };
    LineCallbacks calls;
    calls.changed = [&](const LineState& state) {
      destroy_if(state.phase == LineState::Phase::kOff ? 1 : state.reason.empty() ? 0 : 2);
    };
    calls.failed = [&](const Error&) { destroy_if(3); };
    calls.received = [&](const wire::Telegram&) { destroy_if(4); };
    calls.frame = [&](ByteView, bool outgoing) { destroy_if(outgoing ? 5 : 6); };
    calls.note = [&](const std::string&, std::string_view) { destroy_if(7); };
    RoutingCallbacks more;
    more.lost = [&](const Endpoint&, const wire::RoutingLostMessage&) { destroy_if(8); };
    more.discovery = [&](const Endpoint&, ByteView) { destroy_if(9); };
    RoutingOptions options;
    options.interface_address = here.at;
    line = std::make_unique<RoutingLine>(time, here.lines, options, std::move(calls), std::move(more));
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
    if (line) line->send(write_to(1), SteadyTime::max(), [](SendOutcome, std::string_view) {});
    time.run_for(100ms);
    for (const auto* hex : {"06100201000e08010a4d00019ca4", "0610053000132900bcd011c80a070300800c33", "061005380006",
                            "06100531000a04000005", "06100532000c060000640000"}) {
      // The note of lost messages precedes the call.
      if (when == 8 && std::string_view(hex) == "061005380006") continue;
      from_other(hex);
    }
    time.run_for(1s);
    net.refuses = 50;
    if (line) line->send(write_to(1), SteadyTime::max(), [](SendOutcome, std::string_view) {});
    time.run_for(5s);
    net.refuses = 0;
    EXPECT_EQ(line, nullptr) << when;
  }
  RoutingOptions options;
  options.interface_address = here.at;
  auto line = std::make_unique<RoutingLine>(time, here.lines, options, LineCallbacks{});
  ASSERT_TRUE(line->open());
  line->send(write_to(1), SteadyTime::max(), [&](SendOutcome, std::string_view) { line.reset(); });
  time.run_for(1s);
  EXPECT_EQ(line, nullptr);
}

TEST_F(RoutingLineLife, TelegramsThatWaitForTheLineAreSentWhenItIsUp) {
  Router router(time, here);
  router.send(write_to(1));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, IsEmpty());
  open(router);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent));
}

TEST_F(RoutingLineLife, ADestroyedLineSendsNothing) {
  Router router(time, here);
  open(router);
  router.send(write_to(1));
  router.send(write_to(2));
  time.run_for(1ms);
  router.line.reset();
  other.send({kGroup, kKnxPort}, bytes("0610053000132900bcd011c80a070300800c33"));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, SizeIs(1));
  EXPECT_THAT(router.received, IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::knx::line
