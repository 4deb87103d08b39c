#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {
namespace {

using Phase = LineState::Phase;

class ConnectTest : public LineFixture {
 protected:
  /// Opens without waiting for more than a moment.
  void open() {
    if (!server) make_server();
    make_line();
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
  }
};

TEST_F(ConnectTest, WithoutSocketsOpeningFailsAtOnce) {
  transport::MemoryTransports none;
  TunnelLine alone(options, time, none, {});
  const auto opened = alone.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
}

TEST_F(ConnectTest, AHostThatCannotBeFoundIsNamed) {
  reopens = false;
  options.host = "nowhere.home";
  open();
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("nowhere.home"), std::string::npos);
  EXPECT_EQ(phase(), Phase::kOff);
}

TEST_F(ConnectTest, AClosedPortIsDetectedAtOnceAndTheServerFoundWhenItStarts) {
  make_server();
  server->stop();
  open();
  EXPECT_EQ(failures.size(), 1U);
  time.run_for(3s);
  EXPECT_GT(failures.size(), 3U);
  server->start();
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(ConnectTest, AServerThatRestartsIsFoundAgainWithoutALoss) {
  connect();
  for (std::uint16_t round = 0; round < 20; ++round) {
    server->stop();
    send(round);
    time.run_for(700ms);
    EXPECT_NE(phase(), Phase::kUp);
    server->start();
    time.run_for(2s);
    EXPECT_EQ(phase(), Phase::kUp) << round;
    EXPECT_EQ(sent(round), SendOutcome::kSent) << round;
  }
  EXPECT_EQ(count("reconnects"), 20U);
}

TEST_F(ConnectTest, AServerThatForgotTheTunnelIsDetectedAtTheFirstMissingAck) {
  connect();
  server->forget_all();
  send(1);
  time.run_for(1800ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("status 21"), std::string::npos);
}

TEST_F(ConnectTest, WithoutAnAnswerRouteBackIsUsedAfterTwoSeconds) {
  make_server();
  server->only_route_back = true;
  open();
  time.run_for(1800ms);
  EXPECT_EQ(phase(), Phase::kConnecting);
  time.run_for(200ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_TRUE(failures.empty());
  EXPECT_EQ(server->channels().size(), 2U) << "one is lost for a while, not all";
  send(1);
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  // What worked is remembered.
  server->disconnect_all();
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->counters.connects, 3U);
}

TEST_F(ConnectTest, BehindNatTheOnlyTunnelIsOpenedAfterTheServerDropsTheUnansweredOne) {
  make_server({.tunnels = 1});
  server->only_route_back = true;
  int unreachable = 0;
  net.loses = [&](const transport::MemoryDatagram& datagram) {
    unreachable += datagram.to.address == "203.0.113.1" ? 1 : 0;
    return false;
  };
  open();
  time.run_for(3s);
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_NE(line->state().reason.find("our first request"), std::string::npos) << line->state().reason;
  time.run_for(200s);
  EXPECT_EQ(phase(), Phase::kUp) << line->state().reason;
  EXPECT_LE(unreachable, 2) << "one answer, and its disconnect";
  time.run_for(300s);
  EXPECT_EQ(phase(), Phase::kUp) << "heartbeats go the same way";
  EXPECT_TRUE(failures.empty());
  net.loses = nullptr;
}

TEST_F(ConnectTest, WithoutAnAnswerOnEitherEndpointItFailsAfterTenSeconds) {
  make_server();
  server->answers_connect = false;
  reopens = false;
  open();
  time.run_for(9s);
  EXPECT_TRUE(failures.empty());
  time.run_for(2s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("does not answer"), std::string::npos);
}

TEST_F(ConnectTest, ErrorsOfSendingArePartOfTheReason) {
  make_server();
  reopens = false;
  net.refuses = 1000;
  open();
  time.run_for(11s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("does not answer (UDP 10.0.0.9:3671: 64 datagrams wait already)"), std::string::npos)
      << failures[0].text;
}

TEST_F(ConnectTest, AnAnswerFromAnotherAddressNamesIt) {
  make_server();
  server->answers_connect = false;
  reopens = false;
  transport::MemoryTransports stranger;
  stranger.join(net, "10.0.0.66");
  const auto socket = stranger.open_udp({}, {[](const auto&, ByteView) {}, [](const Error&) {}, [](const Error&) {}});
  open();
  const auto port = net.sent().front().from.port;
  (void)(*socket)->send({"10.0.0.2", port}, *base::from_hex("0610020600080024"));
  time.run_for(11s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("10.0.0.66:"), std::string::npos) << failures[0].text;
  EXPECT_NE(failures[0].text.find("(wrong-source)"), std::string::npos);
}

TEST_F(ConnectTest, ATunnelWithoutARouteEndsAtTheNextDatagramAndComesBack) {
  connect();
  const auto reconnects = count("reconnects");
  net.no_way = "Network is unreachable";
  send(1);
  EXPECT_TRUE(failures.empty()) << "not inside of the call";
  time.run_for(0s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("cannot send: Network is unreachable"), std::string::npos) << failures[0].text;
  EXPECT_NE(phase(), LineState::Phase::kUp);
  time.run_for(2s);
  EXPECT_GE(failures.size(), 3U) << "no attempt waits for an answer";
  net.no_way.clear();
  time.run_for(2s);
  EXPECT_EQ(phase(), LineState::Phase::kUp);
  EXPECT_EQ(count("reconnects"), reconnects + 1);
  EXPECT_EQ(sent(1), SendOutcome::kSent) << "it waited for the line";
}

/// Without commands the heartbeat notices it.
TEST_F(ConnectTest, ATunnelWithoutARouteThatSendsNothingEndsWithTheNextHeartbeat) {
  connect();
  net.no_way = "Network is unreachable";
  time.run_for(61s);
  EXPECT_FALSE(failures.empty()) << "not after four heartbeats of ten seconds";
}

/// A machine without a way to the server.
class NoRoute final : public transport::Transports {
 public:
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return lines.open_file(path);
  }
  std::unique_ptr<transport::Lookup> look_up(const std::string& host, transport::LookupDone done) override {
    return lines.look_up(host, std::move(done));
  }
  Result<std::unique_ptr<transport::UdpSocket>> open_udp(const transport::UdpOptions& options,
                                                         transport::UdpCallbacks calls) override {
    if (options.remote) return fail(ErrorCode::kIo, "cannot connect: Network is unreachable");
    return lines.open_udp(options, std::move(calls));
  }

  transport::MemoryTransports lines;
};

TEST_F(ConnectTest, AHostWithoutARouteFailsAtOnce) {
  NoRoute machine;
  machine.lines.join(net, "10.0.0.3");
  std::vector<Error> reported;
  LineCallbacks calls;
  calls.failed = [&](Error error) { reported.push_back(std::move(error)); };
  TunnelLine alone(options, time, machine, std::move(calls));
  ASSERT_TRUE(alone.open());
  time.run_for(100ms);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_NE(reported[0].text.find("Network is unreachable"), std::string::npos);
}

TEST_F(ConnectTest, RouteBackIsUsedAtOnceWhereConfiguredAndNeverWhereForbidden) {
  make_server();
  server->only_route_back = true;
  options.nat = TunnelOptions::Nat::kOn;
  open();
  EXPECT_EQ(phase(), Phase::kUp);
  options.nat = TunnelOptions::Nat::kOff;
  reopens = false;
  open();
  time.run_for(11s);
  EXPECT_EQ(failures.size(), 1U);
}

TEST_F(ConnectTest, ALostConnectRequestCostsTwoSeconds) {
  make_server();
  server->listens = false;
  open();
  server->listens = true;
  time.run_for(2s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(ConnectTest, ASecondChannelOfARepeatedRequestIsClosed) {
  net.transit = 1100ms;
  open();
  time.run_for(10s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->counters.connects, 2U);
  EXPECT_EQ(server->channels().size(), 1U);
}

TEST_F(ConnectTest, TheDataEndpointMayBeElsewhere) {
  make_server({.data_port = 50000});
  connect();
  send(1);
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(received.size(), 1U);
  std::size_t requests = 0, heartbeats = 0;
  time.run_for(61s);
  for (const auto& datagram : net.sent()) {
    if (datagram.from.address != "10.0.0.2" || datagram.bytes.size() < 4) continue;
    if (datagram.bytes[2] == 4) requests += datagram.to.port == 50000 ? 1 : 100;
    if (datagram.bytes[3] == 7) heartbeats += datagram.to.port == 3671 ? 1 : 100;
  }
  EXPECT_EQ(requests, 3U) << "a request, and two acks";
  EXPECT_EQ(heartbeats, 1U);
}

TEST_F(ConnectTest, WithAllTunnelsInUseItRetriesAfterGrowingPausesAndReportsIt) {
  make_server({.tunnels = 1});
  connect();
  std::vector<LineState> second_states;
  LineCallbacks calls;
  calls.changed = [&](const LineState& state) { second_states.push_back(state); };
  calls.failed = [&](const Error& error) { ADD_FAILURE() << error.text; };
  TunnelLine second(options, time, transports, std::move(calls));
  ASSERT_TRUE(second.open());
  time.run_for(100ms);
  EXPECT_EQ(second.state().phase, Phase::kWaiting);
  EXPECT_EQ(second.state().reason, "all tunnels of the interface are in use (status 24)");
  ASSERT_TRUE(second.open()) << "harmless";
  const auto before = server->counters.connects;
  time.run_for(100s);
  const auto tries = server->counters.connects - before;
  EXPECT_GE(tries, 5U);
  EXPECT_LE(tries, 8U);
  line.reset();
  time.run_for(73s);
  EXPECT_EQ(second.state().phase, Phase::kUp);
  EXPECT_TRUE(second.state().reason.empty());
}

TEST_F(ConnectTest, AConfigurationErrorIsRetriedRarely) {
  make_server();
  server->connect_status = 0x28;
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
  EXPECT_NE(line->state().reason.find("authorise"), std::string::npos);
  EXPECT_TRUE(failures.empty());
  time.run_for(59s);
  EXPECT_EQ(server->counters.connects, 1U);
  time.run_for(2s);
  EXPECT_EQ(server->counters.connects, 2U);
  time.run_for(298s);
  EXPECT_EQ(server->counters.connects, 2U);
  server->connect_status = 0;
  time.run_for(3s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(ConnectTest, AUserEndsThePauseAfterARefusal) {
  make_server();
  server->connect_status = 0x28;
  open();
  ASSERT_EQ(phase(), Phase::kRefused);
  EXPECT_TRUE(line->reopen());
  EXPECT_EQ(phase(), Phase::kRefused) << "in the next turn";
  time.run_for(100ms);
  EXPECT_EQ(server->counters.connects, 2U);
  EXPECT_EQ(line->counters().at("attempts"), 1U);
  server->connect_status = 0;
  EXPECT_TRUE(line->reopen());
  time.run_for(100ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_FALSE(line->reopen()) << "there is no pause";
}

TEST_F(ConnectTest, ABusThatIsDownIsReportedAndRetried) {
  make_server();
  server->connect_status = 0x27;
  open();
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_FALSE(line->state().bus);
  server->connect_status = 0;
  time.run_for(2s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_TRUE(line->state().bus);
}

TEST_F(ConnectTest, RefusalsWithoutAReasonAreRetriedAfterGrowingPauses) {
  for (const std::uint8_t code : Bytes{0x0f, 0x04, 0x77}) {
    server.reset();
    make_server();
    server->connect_status = code;
    open();
    EXPECT_EQ(phase(), Phase::kWaiting);
    time.run_for(100s);
    EXPECT_LE(server->counters.connects, 9U);
    EXPECT_GE(server->counters.connects, 5U);
    server->connect_status = 0;
    time.run_for(73s);
    EXPECT_EQ(phase(), Phase::kUp);
    EXPECT_TRUE(failures.empty());
  }
}

TEST_F(ConnectTest, ARefusalThatConcernsAnOldConnectionIsAFailureForTheCaller) {
  make_server();
  server->connect_status = 0x26;
  reopens = false;
  open();
  EXPECT_EQ(failures.size(), 1U);
  EXPECT_EQ(phase(), Phase::kOff);
}

TEST_F(ConnectTest, AConfiguredTunnelAddressIsRequested) {
  make_server({.wanted_addresses = true});
  options.wanted = wire::IndividualAddress{0x11ca};
  connect();
  EXPECT_EQ(line->state().own, wire::IndividualAddress{0x11ca});
  EXPECT_EQ(count("other-tunnel-address"), 0U);
  const auto first = std::move(line);
  open();
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_EQ(line->state().reason, "the requested tunnel address is in use (status 2E)");
  options.wanted = wire::IndividualAddress{0x1101};
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
}

TEST_F(ConnectTest, AServerWithoutTunnelAddressesInRequestsAssignsAny) {
  options.wanted = wire::IndividualAddress{0x11ca};
  connect();
  EXPECT_EQ(line->state().own, wire::IndividualAddress{0x11c8});
  EXPECT_EQ(server->counters.connects, 2U);
  EXPECT_EQ(count("other-tunnel-address"), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].second, "the interface gave us the tunnel 1.1.200 instead of 1.1.202");
}

TEST_F(ConnectTest, TheRefusalOfATunnelAddressMayArriveTwice) {
  make_server();
  options.wanted = wire::IndividualAddress{0x11ca};
  server->set_weather({.duplicate = 1, .late = 50us});
  open();
  time.run_for(3s);
  EXPECT_EQ(phase(), Phase::kUp) << line->state().reason;
  for (const auto& state : states) EXPECT_NE(state.phase, Phase::kRefused);
}

TEST_F(ConnectTest, AConnectionTypeThatIsNotOfferedIsReportedSoon) {
  make_server();
  options.wanted = wire::IndividualAddress{0x11ca};
  server->connect_status = 0x22;
  open();
  time.run_for(3s);
  EXPECT_EQ(phase(), Phase::kRefused);
}

TEST_F(ConnectTest, HeartbeatsGoOnAndKeepTheTunnel) {
  connect();
  time.run_for(10min);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->counters.heartbeats, 10U);
  EXPECT_TRUE(failures.empty());
}

TEST_F(ConnectTest, FourHeartbeatsWithoutAnswerEndTheTunnel) {
  connect();
  server->answers_heartbeats = false;
  time.run_for(59s + 40s);
  EXPECT_TRUE(failures.empty());
  EXPECT_EQ(server->counters.heartbeats, 4U);
  time.run_for(2s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(server->counters.disconnects, 1U);
  EXPECT_EQ(count("missing-heartbeats"), 4U);
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(ConnectTest, TrafficDoesNotReplaceTheHeartbeat) {
  connect();
  server->answers_heartbeats = false;
  for (std::uint16_t i = 0; i < 102; ++i) {
    send(i);
    time.run_for(1s);
  }
  EXPECT_EQ(failures.size(), 1U);
}

TEST_F(ConnectTest, AHeartbeatAnsweredWithAnErrorIsRepeatedSoon) {
  connect();
  server->heartbeat_status = 0x26;
  time.run_for(62s);
  EXPECT_GE(server->counters.heartbeats, 2U);
  server->heartbeat_status = 0;
  time.run_for(60s);
  EXPECT_TRUE(failures.empty());
  server->heartbeat_status = 0x26;
  time.run_for(10s);
  EXPECT_EQ(failures.size(), 1U);
}

TEST_F(ConnectTest, AHeartbeatReportsABusThatIsDown) {
  connect();
  server->heartbeat_status = 0x27;
  time.run_for(61s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_FALSE(line->state().bus);
  EXPECT_NE(line->state().reason.find("no connection to the KNX bus"), std::string::npos);
  server->heartbeat_status = 0;
  time.run_for(61s);
  EXPECT_TRUE(line->state().bus);
  EXPECT_TRUE(failures.empty());
}

TEST_F(ConnectTest, AForgottenTunnelIsReopenedAtTheNextHeartbeat) {
  connect();
  server->forget_all();
  time.run_for(61s);
  EXPECT_EQ(failures.size(), 1U);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->counters.disconnects, 0U);
}

TEST_F(ConnectTest, ADisconnectIsAnsweredAndTheLineReopened) {
  connect();
  server->next_channel = 77;
  server->disconnect_all();
  time.run_for(10ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(base::to_hex(net.sent().back().bytes), "0610020a00080100");
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->channels(), std::vector<std::uint8_t>{77});
  send(1);
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
}

TEST_F(ConnectTest, TwoClientsThatCompeteForATunnelAreDetected) {
  make_server();
  server->disconnects_at_once = true;
  open();
  time.run_for(10s);
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_NE(line->state().reason.find("compete"), std::string::npos);
  EXPECT_EQ(server->counters.connects, 4U);
  EXPECT_EQ(failures.size(), 3U);
  time.run_for(35s);
  EXPECT_EQ(server->counters.connects, 4U);
  time.run_for(35s);
  EXPECT_EQ(server->counters.connects, 5U);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
