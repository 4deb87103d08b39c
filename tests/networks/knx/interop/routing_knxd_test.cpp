#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "networks/knx/line/routing_line.h"
#include "support/knxd.h"
#include "transport/interfaces.h"
#include "transport/worlds.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;
using support::Knxd;
using support::KnxdListener;
using support::KnxNetwork;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Our client and knxd on one made-up interface: two programs of unlike origin on one machine and one port.
class WithKnxd : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!network.entered()) GTEST_SKIP() << network.reason();
    world = std::make_unique<transport::MachineWorld>();
    knxd = std::make_unique<Knxd>();
    ASSERT_TRUE(world->until([&] { return knxd->ready(); })) << knxd->errors();
  }
  void open_line() {
    LineCallbacks calls;
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.failed = [](const Error& why) { ADD_FAILURE() << why.text; };
    RoutingOptions options;
    options.interface_address = KnxNetwork::kAddress;
    line = std::make_unique<RoutingLine>(world->loop.scheduler(), world->local, options, calls);
    ASSERT_TRUE(line->open());
  }
  void write(std::uint16_t group, Bytes value) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress(group);
    telegram.payload = {std::move(value), false};
    line->send(telegram, world->loop.scheduler().now() + 1min, [this](SendOutcome outcome, std::string_view why) {
      EXPECT_EQ(outcome, SendOutcome::kSent) << why;
      ++sent;
    });
  }
  DiscoveryResult discover(DiscoveryOptions options) {
    options.collect = 1s;  // of real time; it answers at once
    options.repeat = 300ms;
    std::optional<DiscoveryResult> result;
    const Discovery discovery(world->loop.scheduler(), world->local, std::move(options),
                              [&](DiscoveryResult found) { result = std::move(found); });
    EXPECT_TRUE(world->until([&] { return result.has_value(); }));
    return result.value_or(DiscoveryResult{});
  }

  KnxNetwork network;
  std::unique_ptr<transport::MachineWorld> world;
  std::unique_ptr<Knxd> knxd;
  std::unique_ptr<RoutingLine> line;
  std::vector<wire::Telegram> received;
  int sent = 0;
};

TEST_F(WithKnxd, WhatWeWriteIsHeardOnItsBusAllAndInOrder) {
  open_line();
  const KnxdListener listener(*knxd);
  int tries = 0;
  ASSERT_TRUE(world->until([&] {
    if (sent == tries) write(0x0a06, {static_cast<std::uint8_t>(++tries)});
    return listener.heard().find("Write from 15.15.250 to 1/2/6: ") != std::string::npos;
  })) << "the listener is there";
  std::string expected;
  for (std::uint8_t i = 0; i < 50; ++i) {
    write(0x0a07, {0x0c, i});
    expected += fmt::format("Write from 15.15.250 to 1/2/7: 0C {:02X} \n", i);
  }
  EXPECT_TRUE(world->until([&] { return listener.heard().find(" to 1/2/7: 0C 31 ") != std::string::npos; }));
  EXPECT_THAT(listener.heard(), HasSubstr(expected));
  EXPECT_THAT(received, IsEmpty()) << "own frames come back and are recognised";
}

TEST_F(WithKnxd, WhatItsUsersWriteIsHeardByUs) {
  open_line();
  EXPECT_EQ(knxd->tool("groupwrite", {"1/2/8", "0c", "65"}).code, 0);
  EXPECT_EQ(knxd->tool("groupswrite", {"1/2/9", "1"}).code, 0);
  EXPECT_EQ(knxd->tool("groupread", {"1/2/10"}).code, 0);
  ASSERT_TRUE(world->until([&] { return received.size() == 3; }));
  EXPECT_EQ(received[0].destination, wire::GroupAddress(0x0a08));
  EXPECT_EQ(received[0].payload, (wire::Payload{{0x0c, 0x65}, false}));
  EXPECT_EQ(number(received[0].source) >> 8, 0x11) << "one of 1.1.200 and up";
  EXPECT_EQ(received[1].payload, (wire::Payload{{1}, true}));
  EXPECT_EQ(received[2].service, wire::Service::kRead);
}

TEST_F(WithKnxd, AReadOfOursIsAnsweredByItsUser) {
  open_line();
  wire::Telegram read;
  read.service = wire::Service::kRead;
  read.destination = wire::GroupAddress(0x0a05);
  line->send(read, world->loop.scheduler().now() + 1min, {});
  ASSERT_TRUE(world->until([&] { return line->counters().at("telegrams-sent") == 1; }));
  EXPECT_EQ(knxd->tool("groupsresponse", {"1/2/5", "1"}).code, 0);
  ASSERT_TRUE(world->until([&] { return received.size() == 1; }));
  EXPECT_EQ(received[0].service, wire::Service::kResponse);
}

TEST_F(WithKnxd, ASearchFindsIt) {
  const auto found = discover({{KnxNetwork::kAddress}, {}});
  ASSERT_THAT(found.servers, SizeIs(1));
  EXPECT_THAT(found.problems, IsEmpty());
  EXPECT_EQ(found.servers[0].control, (transport::Endpoint{KnxNetwork::kAddress, kKnxPort}));
  EXPECT_THAT(describe(found.servers[0]), HasSubstr("test-knxd  10.77.0.1:3671  1.1.250  TP1\n"));
  EXPECT_THAT(describe(found.servers[0]), HasSubstr("core 1, tunnelling 1, routing 1"));
}

TEST_F(WithKnxd, ItDescribesItselfWhenAskedAndTheAnswersAreMerged) {
  const transport::Endpoint host{KnxNetwork::kAddress, kKnxPort};
  const auto described = discover({{}, {host}});
  ASSERT_THAT(described.servers, SizeIs(1));
  EXPECT_EQ(described.servers[0].description.name, "test-knxd");
  EXPECT_EQ(described.servers[0].description.version(wire::Family::kDeviceManagement), 1);
  const auto both = discover({{KnxNetwork::kAddress}, {host}});
  ASSERT_THAT(both.servers, SizeIs(1));
  EXPECT_THAT(describe(both.servers[0]), HasSubstr("serial     010203040506")) << "only in the search response";
  EXPECT_EQ(both.servers[0].description.version(wire::Family::kDeviceManagement), 1) << "only in the description";
}

TEST_F(WithKnxd, AnAnswerToWhereTheQuestionCameFromReachesUsToo) {
  DiscoveryOptions options{{KnxNetwork::kAddress}, {}};
  options.route_back = true;
  EXPECT_THAT(discover(options).servers, SizeIs(1));
}

TEST_F(WithKnxd, AHostWithoutAServerIsReportedAtOnce) {
  const auto found = discover({{}, {{KnxNetwork::kAddress, 3999}}});
  ASSERT_THAT(found.problems, SizeIs(1));
  EXPECT_THAT(found.problems[0].text, HasSubstr("no program listens on that port"));
}

TEST_F(WithKnxd, TheInterfaceIsListed) {
  const auto all = transport::ipv4_interfaces();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& one) { return one.name == "veth0"; });
  ASSERT_NE(found, all.end());
  EXPECT_EQ(*found, (transport::Interface{"veth0", KnxNetwork::kAddress, true, true, false, true, found->index}));
  EXPECT_GT(found->index, 0U);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
