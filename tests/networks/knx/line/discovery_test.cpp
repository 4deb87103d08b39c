#include "networks/knx/line/discovery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "networks/knx/line/host.h"
#include "support/knx_server.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// Of knxd 0.14.54 (knx.md, section 18), its control endpoint 10.77.0.1:3671; the name padded to 30 bytes.
const std::string kSearchResponse =
    "06100202004c08010a4d00010e57"
    "3601020011fa0000010203040506e000170c2a6c383bd812" +
    base::to_hex(base::as_bytes("test-knxd")) + std::string(42, '0') + "0802020104010501";

class Discovering : public ::testing::Test {
 protected:
  void start(DiscoveryOptions options) {
    begun = time.now();
    discovery = std::make_unique<Discovery>(time, here.lines, std::move(options), [this](DiscoveryResult found) {
      ASSERT_FALSE(result) << "once only";
      result = std::move(found);
      took = time.now() - begun;
      discovery.reset();
    });
    EXPECT_FALSE(result) << "never from inside the call";
  }
  static DiscoveryOptions search() { return {{"10.77.0.2"}, {}}; }
  static DiscoveryOptions description() { return {{}, {{"10.77.0.1", kKnxPort}}}; }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  Host here{net, "10.77.0.2"};
  Host server{net, "10.77.0.1"};
  SteadyTime begun{};
  Duration took{};
  std::unique_ptr<Discovery> discovery;
  std::optional<DiscoveryResult> result;
};

TEST_F(Discovering, ASearchIsSentTwiceInBothFormsAndEndsAfterThreeSeconds) {
  server.listen({std::string(kKnxGroup)}, kKnxPort);
  start(search());
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_EQ(took, 3s);
  const Endpoint from{"10.77.0.2", 49152};
  const std::pair plain(from, std::string("06100201000e08010a4d0002c000"));
  const std::pair extended(from, std::string("0610020b001408010a4d0002c000060401020607"));
  EXPECT_THAT(server.received, ElementsAre(plain, extended, plain, extended));
  EXPECT_THAT(result->servers, IsEmpty());
  EXPECT_THAT(result->problems, IsEmpty());
  EXPECT_EQ(net.open_sockets(), 1u) << "only the server's is left";
}

TEST_F(Discovering, AnswersOfKnxdAreRead) {
  server.listen({std::string(kKnxGroup)}, kKnxPort);
  server.answer = [&](const Endpoint& from, ByteView frame) {
    if (frame[3] == 1) server.send(from, bytes(kSearchResponse));  // knxd is silent to extended searches
  };
  start(search());
  time.run_for(10s);
  ASSERT_TRUE(result);
  ASSERT_THAT(result->servers, SizeIs(1)) << "although it answered twice";
  const auto& found = result->servers[0];
  EXPECT_EQ(found.control, (Endpoint{"10.77.0.1", 3671}));
  EXPECT_EQ(found.description.name, "test-knxd");
  EXPECT_EQ(to_string(found.description.address), "1.1.250");
  EXPECT_EQ(found.description.version(wire::Family::kRouting), 1);
  EXPECT_FALSE(found.extended);
  EXPECT_EQ(describe(found),
            "test-knxd  10.77.0.1:3671  1.1.250  TP1\n"
            "  serial     010203040506\n"
            "  MAC        2a:6c:38:3b:d8:12\n"
            "  group      224.0.23.12\n"
            "  families   core 1, tunnelling 1, routing 1");
}

TEST_F(Discovering, AnswersOfOneServerAreMergedByItsControlEndpoint) {
  wire::ServerDescription plain;
  plain.name = "router";
  plain.medium = 0x02;
  plain.address = wire::IndividualAddress(0x1101);
  plain.serial = {1, 2, 3, 4, 5, 6};
  plain.families = {{wire::Family::kCore, 1}, {wire::Family::kRouting, 1}};
  auto rich = plain;
  rich.serial = {};
  rich.families = {{wire::Family::kCore, 2}, {wire::Family::kTunnelling, 2}};
  rich.secured = {{wire::Family::kTunnelling, 1}};
  rich.max_apdu = 254;
  rich.slots = {{wire::IndividualAddress(0x1102), true, true, true},
                {wire::IndividualAddress(0x1103), true, false, false}};
  server.listen({std::string(kKnxGroup)}, kKnxPort);
  server.answer = [&](const Endpoint& from, ByteView frame) {
    const bool extended = frame[3] == 0x0b;
    // Route back: the control endpoint is where the answer comes from.
    const wire::SearchResponse response{extended ? wire::Hpai{} : wire::udp_hpai("10.77.0.1", 3671), extended,
                                        wire::to_dibs(extended ? rich : plain)};
    server.send(from, write(wire::Message(response)));
  };
  start(search());
  time.run_for(10s);
  ASSERT_TRUE(result);
  ASSERT_THAT(result->servers, SizeIs(1));
  const auto& found = result->servers[0];
  EXPECT_TRUE(found.extended);
  EXPECT_EQ(found.free_slots(), 1u);
  EXPECT_EQ(describe(found),
            "router  10.77.0.1:3671  1.1.1  TP1\n"
            "  serial     010203040506\n"
            "  families   core 2, routing 1, tunnelling 2\n"
            "  secure     tunnelling 1 (KNX IP Secure is required: configure `via: tunnel-tcp` and `keyring: "
            "FILE.knxkeys`)\n"
            "  max APDU   254 bytes\n"
            "  tunnels    1 of 2 free: 1.1.2 free, 1.1.3 used (needs authorisation)");
}

TEST_F(Discovering, SeveralServersAndInterfacesAreFoundAndBrokenOnesCounted) {
  server.listen({std::string(kKnxGroup)}, kKnxPort);
  Host other(net, "10.77.0.3"), broken(net, "10.77.0.4");
  other.listen({std::string(kKnxGroup)}, kKnxPort);
  broken.listen({std::string(kKnxGroup)}, kKnxPort);
  for (auto* host : {&server, &other}) {
    host->answer = [host](const Endpoint& from, ByteView) {
      wire::ServerDescription description;
      description.name = host->at;
      host->send(from, write(wire::Message(
                           wire::SearchResponse{wire::udp_hpai(host->at, 3671), false, wire::to_dibs(description)})));
    };
  }
  broken.answer = [&](const Endpoint& from, ByteView) {
    for (const auto* hex : {"0610", "061002020010080100000000000000ff", "06100202000e08010a4d00040e57"})
      broken.send(from, bytes(hex));
  };
  auto options = search();
  options.interfaces.emplace_back("192.0.2.1");
  start(options);
  time.run_for(10s);
  ASSERT_TRUE(result);
  ASSERT_THAT(result->servers, SizeIs(3)) << "one tells no more than its endpoint";
  EXPECT_EQ(result->servers[0].description.name, "10.77.0.1");
  EXPECT_EQ(result->servers[1].description.name, "10.77.0.3");
  EXPECT_EQ(result->bad_frames, 8u) << "two each time";
  ASSERT_THAT(result->problems, SizeIs(1));
  EXPECT_THAT(result->problems[0].text, HasSubstr("interface 192.0.2.1 cannot be searched"));
}

TEST_F(Discovering, AFloodOfServersIsBounded) {
  start(search());
  for (int i = 0; i < 5000; ++i) {
    const wire::Hpai control = wire::udp_hpai("10.0.0.1", static_cast<std::uint16_t>(i + 1));
    discovery->receive({"10.0.0.1", 3671},
                       write(wire::Message(wire::SearchResponse{control, false, wire::to_dibs({})})));
  }
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->servers.size(), FoundServers::kMaxServers);
  EXPECT_EQ(result->bad_frames, 5000 - FoundServers::kMaxServers);
}

TEST_F(Discovering, AHostIsQueriedByNameAndTheAnswerEndsTheWait) {
  net.name("gateway.example", {"10.77.0.1"});
  server.listen({}, kKnxPort);
  server.answer = [&](const Endpoint& from, ByteView) {
    auto response = bytes(kSearchResponse);  // the same blocks without the endpoint
    response.erase(response.begin() + 6, response.begin() + 14);
    response[3] = 4, response[5] = static_cast<std::uint8_t>(response.size());
    server.send(from, response);
  };
  start({{}, {{"gateway.example", kKnxPort}}});
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_LT(took, 100ms);
  EXPECT_THAT(server.received, ElementsAre(std::pair(Endpoint{"10.77.0.2", 49152}, "06100203000e08010a4d0002c000")));
  ASSERT_THAT(result->servers, SizeIs(1));
  EXPECT_EQ(result->servers[0].control, (Endpoint{"10.77.0.1", 3671}));
  EXPECT_EQ(result->servers[0].description.name, "test-knxd");
}

TEST_F(Discovering, ASilentHostIsQueriedTwiceTheSecondTimeWithRouteBack) {
  server.listen({}, kKnxPort);
  start(description());
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_EQ(took, 6s + net.lookup_time);
  ASSERT_THAT(server.received, SizeIs(2));
  EXPECT_EQ(server.received[1].second, "06100203000e0801000000000000");
  ASSERT_THAT(result->problems, SizeIs(1));
  EXPECT_EQ(result->problems[0].text, "10.77.0.1:3671 does not describe itself: no answer within 6 s");
}

/// A description of a server of version 2 has no block of secured families (Calimero; knx.md, section 3.4).
TEST_F(Discovering, AHostOfVersionTwoIsQueriedForItsSecuredServices) {
  wire::ServerDescription plain;
  plain.name = "secure only";
  plain.medium = 0x20;
  plain.families = {{wire::Family::kCore, 2}, {wire::Family::kTunnelling, 2}};
  auto rich = plain;
  rich.secured = {{wire::Family::kTunnelling, 1}};
  server.listen({}, kKnxPort);
  server.answer = [&](const Endpoint& from, ByteView frame) {
    server.send(from, frame[3] == 3
                          ? write(wire::Message(wire::DescriptionResponse{wire::to_dibs(plain)}))
                          : write(wire::Message(wire::SearchResponse{wire::Hpai{}, true, wire::to_dibs(rich)})));
  };
  start(description());
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_LT(took, 100ms);
  ASSERT_THAT(server.received, SizeIs(2));
  EXPECT_EQ(server.received[1].second, "0610020b001408010a4d0002c000060401020607");
  ASSERT_THAT(result->servers, SizeIs(1));
  EXPECT_THAT(describe(result->servers[0]), HasSubstr("tunnelling 1 (KNX IP Secure is required: configure `via"));
  EXPECT_EQ(to_string(result->servers[0].security()), "required");
  EXPECT_THAT(result->problems, IsEmpty());
}

TEST_F(Discovering, TheSimulatorSaysThatItsTunnelsAreSecured) {
  support::KnxServer::Options options;
  options.at = {"10.77.0.9", kKnxPort};
  options.secure.emplace();
  const support::KnxServer simulator(time, net, options);
  start({{}, {{"10.77.0.9", kKnxPort}}});
  time.run_for(10s);
  ASSERT_TRUE(result);
  ASSERT_THAT(result->servers, SizeIs(1));
  const auto& found = result->servers[0];
  EXPECT_EQ(to_string(found.security()), "required");
  EXPECT_THAT(describe(found), HasSubstr("tunnelling 1 (KNX IP Secure is required: configure `via: tunnel-tcp`"));
  EXPECT_THAT(describe(found), HasSubstr("254 bytes"));
  EXPECT_EQ(found.free_slots(), 4U);
  EXPECT_EQ(found.control, (Endpoint{"10.77.0.9", kKnxPort}));
}

TEST(FoundServers, SayWhetherSecureConnectionsAreRequired) {
  FoundServer server;
  EXPECT_EQ(to_string(server.security()), "unknown") << "a plain search does not say it";
  EXPECT_THAT(describe(server), Not(HasSubstr("secure")));
  server.extended = true;
  EXPECT_THAT(describe(server), HasSubstr("\n  secure     not required"));
  server.description.families = {{wire::Family::kCore, 2}, {wire::Family::kSecurity, 1}};
  EXPECT_EQ(to_string(server.security()), "possible");
  EXPECT_THAT(describe(server), HasSubstr("\n  secure     possible, not required"));
  server.description.secured = {{wire::Family::kRouting, 1}};
  EXPECT_EQ(to_string(server.security()), "required");
  EXPECT_THAT(describe(server), HasSubstr("routing 1 (KNX IP Secure is required: configure `keyring: FILE.knxkeys`)"));
  server.description.secured = {{wire::Family::kDeviceManagement, 1}};
  EXPECT_THAT(describe(server), HasSubstr("device management 1 (KNX IP Secure is required)"));
}

TEST_F(Discovering, AHostWithoutExtendedSearchIsDescribedToo) {
  wire::ServerDescription plain;
  plain.families = {{wire::Family::kCore, 2}};
  server.listen({}, kKnxPort);
  server.answer = [&](const Endpoint& from, ByteView frame) {
    if (frame[3] == 3) server.send(from, write(wire::Message(wire::DescriptionResponse{wire::to_dibs(plain)})));
  };
  start(description());
  time.run_for(10s);
  ASSERT_TRUE(result);
  EXPECT_THAT(result->servers, SizeIs(1));
  EXPECT_THAT(result->problems, IsEmpty());
}

TEST_F(Discovering, AClosedPortAndAnUnknownNameAreReportedAtOnce) {
  start({{}, {{"10.77.0.1", kKnxPort}, {"unknown.example", kKnxPort}}});
  time.run_for(100ms);
  ASSERT_TRUE(result);
  ASSERT_THAT(result->problems, SizeIs(2));
  std::string all;
  for (const auto& problem : result->problems) all += problem.text + "\n";
  EXPECT_THAT(all, HasSubstr("10.77.0.1:3671 does not describe itself: no program listens on that port"));
  EXPECT_THAT(all, HasSubstr("unknown.example cannot be found"));
}

TEST_F(Discovering, RouteBackIsRequestedWhereConfigured) {
  server.listen({std::string(kKnxGroup)}, kKnxPort);
  auto options = search();
  options.route_back = true;
  start(options);
  time.run_for(10s);
  ASSERT_THAT(server.received, SizeIs(4));
  EXPECT_EQ(server.received[0].second, "06100201000e0801000000000000");
}

TEST_F(Discovering, MayBeEndedBefore) {
  start(search());
  time.run_for(1s);
  discovery.reset();
  time.run_for(10s);
  EXPECT_FALSE(result);
  EXPECT_EQ(net.open_sockets(), 0u);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
