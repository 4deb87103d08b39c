#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "transport/worlds.h"
#include "tuples/peis/node.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::Each;
using ::testing::SizeIs;

/// A node on sockets of the machine.
struct MachineNode {
  MachineNode(transport::MachineWorld& world, std::uint32_t id, std::vector<std::string> connect) {
    NodeOptions options;
    options.id = OwnerId{id};
    options.magic = 0x2000000 + id;
    options.host_name = "hostx";
    options.full_name = "ours@hostx!" + std::to_string(id);
    options.hello.host_id = "one-host";
    options.first_port = 0;
    options.multicast = false;
    options.interfaces = {{"lo", "127.0.0.1", true, true, true}};
    options.connect = std::move(connect);
    NodeCallbacks calls;
    calls.message = [this](OwnerId, Port, ByteView body) { texts.emplace_back(base::as_text(body)); };
    calls.host = [this](HostEvent event, const Identity& host) {
      if (event == HostEvent::kUp) ++ups;
      if (event == HostEvent::kLeft) ++lefts;
      hello = host.hello.has_value();
    };
    calls.ready = [](OwnerId) {};
    calls.id_taken = [](const Identity&) {};
    auto opened = Node::open(options, world.loop.scheduler(), world.local, Log(sink, "peis"), std::move(calls));
    EXPECT_TRUE(opened) << opened.error().text;
    node = std::move(*opened);
  }

  base::NullLogSink sink;
  std::unique_ptr<Node> node;
  std::vector<std::string> texts;
  int ups = 0, lefts = 0;
  bool hello = false;
};

TEST(NodeOnTheMachine, TwoNodesMeetExchangeMessagesInOrderAndSayGoodbye) {
  transport::MachineWorld world;
  MachineNode one(world, 1, {});
  MachineNode two(world, 2, {transport::to_string(one.node->local())});
  ASSERT_TRUE(world.until([&] { return one.ups == 1 && two.ups == 1; }));
  EXPECT_TRUE(one.hello);
  EXPECT_TRUE(two.hello);

  std::vector<std::string> sorted;
  std::vector<Outcome> outcomes;
  const auto done = [&](Outcome outcome) { outcomes.push_back(outcome); };
  for (int i = 0; i < 2000; ++i) {
    sorted.push_back(std::to_string(i) + std::string(200, 'x'));
    ASSERT_TRUE(one.node->send(OwnerId{2}, Port::kPush, base::as_bytes(sorted.back()), done));
  }
  const std::string large(300'000, 'l');
  ASSERT_TRUE(two.node->send(OwnerId{1}, Port::kSetRemote, base::as_bytes(large), done));
  ASSERT_TRUE(world.until([&] { return outcomes.size() == 2001; }));
  EXPECT_THAT(outcomes, Each(Outcome::kDelivered));
  EXPECT_EQ(two.texts, sorted);
  ASSERT_THAT(one.texts, SizeIs(1));
  EXPECT_TRUE(one.texts[0] == large);

  two.node.reset();
  EXPECT_TRUE(world.until([&] { return one.lefts == 1; }));
  EXPECT_TRUE(world.until([&] { return one.node->links().empty(); }));
}

}  // namespace
}  // namespace rubicon::tuples::peis
