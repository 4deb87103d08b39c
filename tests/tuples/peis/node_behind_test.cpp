#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/kernel_peer.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A kernel that knows this node, and a young one that joined by way of it and says who it is and what it wants at
/// once.
class NodeBehind : public ::testing::Test {
 protected:
  NodeBehind() {
    own.options.multicast = false;
    EXPECT_TRUE(own.open());
    old.connect(own.node->local().port);
    world.run(1s);
    old.received.clear();
    own.on_message = [this](const OwnNode::Message&) { was_here = own.node->is_here(OwnerId{301}); };
  }
  /// What comes from 301 by way of the old kernel.
  void pass(Routing routing, Port port, ByteView body, std::uint32_t ack_id) {
    auto header = old.header(routing, port, routing == Routing::kDirect ? 102 : kAnyId);
    header.source = OwnerId{301};
    header.hops = 2;
    header.ack_id = ack_id;
    if (routing == Routing::kDirect) header.flags = kFlagWantsAck;
    old.send_raw(header, body);
  }
  void introduce() { pass(Routing::kBroadcast, Port::kHostInfo, write(HostRecordMessage{young.record(), false}), 1); }
  void set(const std::string& text) { pass(Routing::kDirect, Port::kSetRemote, base::as_bytes(text), ++acks_); }
  std::size_t acknowledged() const {
    std::size_t count = 0;
    for (const auto* kernel : {&old, &young}) {
      for (const auto& package : kernel->received) {
        if (package.header.port == Port::kAcks && package.header.destination == OwnerId{301}) ++count;
      }
    }
    return count;
  }

  PeisWorld world;
  OwnNode own{world, 102};
  KernelPeer old{world, 101, 9001}, young{world, 301, 9003};
  bool was_here = false;

 private:
  std::uint32_t acks_ = 100;
};

TEST_F(NodeBehind, WhatAKernelOfAnotherHostWantsIsTakenAtOnceAndNotAfterTheNextRouting) {
  young.host_name = "elsewhere";
  introduce();
  set("go");
  world.run(100ms);
  EXPECT_THAT(own.texts(), ElementsAre("go"));
  world.run(1s);
  EXPECT_EQ(acknowledged(), 1U) << "by the way that it came";
  EXPECT_FALSE(was_here);
}

TEST_F(NodeBehind, ANewStartOfAKernelIsTakenAtOnceToo) {
  young.host_name = "elsewhere";
  young.listen();
  introduce();
  world.run(3s);  // it was connected to, and ends without a word
  ASSERT_TRUE(own.sees(301));
  young.close();
  young.stop_listening();
  world.run(30s);
  ++young.magic;
  introduce();
  set("again");
  world.run(100ms);
  EXPECT_THAT(own.texts(), ElementsAre("again"));
}

TEST_F(NodeBehind, ARequestOfAKernelOfThisHostWaitsUntilItsConnectionShowsThat) {
  young.listen();
  introduce();
  set("go");
  set("on");
  EXPECT_THAT(own.texts(), IsEmpty());
  world.run(1s);
  EXPECT_THAT(own.texts(), ElementsAre("go", "on"));
  EXPECT_TRUE(was_here);
}

/// It says that it is of this host, and its own connection shows that it is not.
TEST_F(NodeBehind, ARequestOverAConnectionFromAnotherHostIsJudgedAtOnce) {
  transport::MemoryTransports elsewhere;
  elsewhere.join(world.net, "10.0.0.2");
  KernelPeer far(world.time, elsewhere, 302, 9004);
  far.connect(own.node->local().port);
  world.run(1s);
  ASSERT_TRUE(own.sees(302));
  ASSERT_EQ(own.node->host(OwnerId{302})->host_name, own.options.host_name);
  far.send(102, Port::kSetRemote, "go");
  world.run(200ms);
  EXPECT_THAT(own.texts(), ElementsAre("go"));
  EXPECT_FALSE(own.node->is_here(OwnerId{302}));
}

TEST_F(NodeBehind, AKernelThatHasTheIdOfThisNodeIsAskedAndReported) {
  KernelPeer twin(world, 102, 9005);
  const auto claim = [&] {
    auto header = old.header(Routing::kBroadcast, Port::kHostInfo);
    header.source = OwnerId{102};
    old.send_raw(header, write(HostRecordMessage{twin.record(), false}));
    world.run(3s);
  };
  claim();
  EXPECT_THAT(own.taken, IsEmpty()) << "nobody is there";
  EXPECT_EQ(own.node->counters().own_id_seen, 1U);
  twin.listen();
  claim();
  ASSERT_THAT(own.taken, SizeIs(1));
  EXPECT_EQ(own.taken[0].magic, twin.magic);
  EXPECT_THAT(world.sink.lines, ::testing::Contains(::testing::HasSubstr("another component uses the id 102")));
}

TEST_F(NodeBehind, ARequestOfOneWhosePlaceIsNotShownIsJudgedAfterFiveSecondsAndNotAcknowledgedBefore) {
  introduce();
  set("go");
  world.run(4900ms);
  EXPECT_THAT(own.texts(), IsEmpty());
  EXPECT_EQ(acknowledged(), 0U) << "the kernel would not send it again";
  world.run(1s);
  EXPECT_THAT(own.texts(), ElementsAre("go"));
  EXPECT_EQ(acknowledged(), 1U);
  EXPECT_FALSE(was_here);
  set("on");
  world.run(100ms);
  EXPECT_THAT(own.texts(), SizeIs(2)) << "it does not wait each time";
}

TEST_F(NodeBehind, ARequestThatItsKernelSendsAgainWhileItWaitsIsHeldOnce) {
  introduce();
  for (int i = 0; i < 40; ++i) pass(Routing::kDirect, Port::kSetRemote, base::as_bytes(std::string_view("go")), 101);
  world.run(6s);
  EXPECT_THAT(own.texts(), ElementsAre("go"));
  EXPECT_EQ(own.node->counters().held_requests, 0U) << "there is room for 32";
}

TEST_F(NodeBehind, WhatWaitsComesBeforeALaterRequestThatNeedNotWait) {
  introduce();
  set("go");
  young.host_name = "elsewhere";
  introduce();
  set("on");
  world.run(100ms);
  EXPECT_THAT(own.texts(), ElementsAre("go", "on"));
}

TEST_F(NodeBehind, TheOwnWordsThatComeBackAreNoOtherComponent) {
  KernelPeer mirror(world, 102, 9005);
  mirror.magic = own.options.magic;
  auto header = old.header(Routing::kBroadcast, Port::kHostInfo);
  header.source = OwnerId{102};
  old.send_raw(header, write(HostRecordMessage{mirror.record(), false}));
  world.run(3s);
  EXPECT_EQ(own.node->counters().own_id_seen, 0U);
}

TEST_F(NodeBehind, RequestsThatWaitAreBoundedAndCounted) {
  introduce();
  for (int i = 0; i < 300; ++i) set(std::string(900, 'x'));
  world.run(1s);
  EXPECT_EQ(own.node->counters().held_requests, 300U - 32U);
}

TEST_F(NodeBehind, WhatComesByWayOfAnotherEndsNoStartThatMayComeBack) {
  young.connect(own.node->local().port);
  world.run(1s);
  ASSERT_TRUE(own.sees(301));
  young.close();  // its connection breaks
  world.run(1s);
  own.events.clear();
  const auto magic = young.magic;
  ++young.magic;
  introduce();
  world.run(1s);
  EXPECT_THAT(own.events_of(301), IsEmpty());
  young.magic = magic;
  young.connect(own.node->local().port);
  world.run(1s);
  ASSERT_TRUE(own.sees(301));
  EXPECT_EQ(own.node->host(OwnerId{301})->magic, magic);
}

}  // namespace
}  // namespace rubicon::tuples::peis
