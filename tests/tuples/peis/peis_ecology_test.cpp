#include "tuples/peis/peis_ecology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rubicon/tuple_space.hpp"
#include "tuples/joined/joined_ecology.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peis/link_to_a_kernel.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

class PeisEcologies : public ::testing::Test {
 protected:
  PeisMachine machine(const std::string& process = "1") const {
    return {world.interfaces, "hostx", "host-of-hostx", process, "anna"};
  }
  std::unique_ptr<PeisEcology> open(PeisOptions options, const std::string& process = "1") {
    options.multicast = false;
    return std::move(*PeisEcology::open(std::move(options), world.time, world.machine, log, machine(process)));
  }
  Result<std::unique_ptr<PeisEcology>> refused(const PeisOptions& options) {
    return PeisEcology::open(options, world.time, world.machine, log, machine());
  }
  static PeisOptions connected_to(const std::string& where) {
    PeisOptions options;
    options.connect = {where};
    return options;
  }

  PeisWorld world;
  support::CollectingLog log;
};

TEST_F(PeisEcologies, RefuseIdsThatKernelsDoNotTakeAndIdsThatArePresent) {
  const auto ecology = open({});
  EXPECT_EQ(ecology->join(OwnerId{0}).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(ecology->join(OwnerId{0x80000000}).error().code, ErrorCode::kOutOfRange);
  auto link = ecology->join(OwnerId{7});
  ASSERT_TRUE(link);
  EXPECT_EQ(ecology->join(OwnerId{7}).error().code, ErrorCode::kDuplicate);
  link->reset();
  EXPECT_TRUE(ecology->join(OwnerId{7}));
}

TEST_F(PeisEcologies, RefuseInterfacesThatAreNotThereAndLeasesOutOfRange) {
  PeisOptions options;
  options.interfaces = {"eth7"};
  EXPECT_THAT(refused(options).error().text, HasSubstr("no interface 'eth7'"));
  options.interfaces.clear();
  EXPECT_EQ(refused(options).error().code, ErrorCode::kOutOfRange);
  options = {};
  options.lease = 100ms;
  EXPECT_EQ(refused(options).error().code, ErrorCode::kOutOfRange);
}

TEST_F(PeisEcologies, TheLaterOfTwoComponentsWithOneIdIsReported) {
  std::vector<std::string> displaced;
  const auto one = std::move(*PeisEcology::open({}, world.time, world.machine, log, machine("1")));
  const auto two = std::move(*PeisEcology::open({}, world.time, world.machine, log, machine("2")));
  one->watch_displaced([&](OwnerId) { displaced.emplace_back("one"); });
  two->watch_displaced([&](OwnerId id) { displaced.push_back("two " + std::to_string(number(id))); });
  const auto first = std::move(*one->join(OwnerId{7}));
  TupleSpace early(OwnerId{7}, world.time, *first);
  world.run(1min);
  const auto second = std::move(*two->join(OwnerId{7}));
  TupleSpace late(OwnerId{7}, world.time, *second);
  world.run(30s);
  EXPECT_THAT(displaced, ElementsAre("two 7"));
  EXPECT_THAT(log.lines, Contains(HasSubstr("another component uses the id 7")));
}

TEST_F(PeisEcologies, RemoteSetsOfOtherHostsNeedTrust) {
  KernelPeer kernel(world, 101, 9000);
  kernel.host_name = "elsewhere";
  kernel.listen();
  for (const bool trusts : {false, true}) {
    auto options = connected_to("127.0.0.1:9000");
    options.trust_lan = trusts;
    const auto ecology = open(options, trusts ? "1" : "2");
    const auto link = std::move(*ecology->join(kSelf));
    TupleSpace space(kSelf, world.time, *link);
    int sets = 0;
    const auto policy = space.add_policy(*Pattern::parse("act"), [&](const RemoteSet&) {
      ++sets;
      return SetDecision::applied();
    });
    world.run(5s);
    NetworkTuple set;
    set.owner = kSelf;
    set.key = "act";
    set.creator = kKernel;
    set.write_time = set.user_time = set.expire_time = WallTime{};
    set.encoding = Encoding::kAscii;
    set.media_type = "text/plain";
    set.data = "1";
    kernel.send(200, Port::kSetRemote, text_of(write_set_remote(set)));
    world.run(1s);
    EXPECT_EQ(sets, trusts ? 1 : 0);
  }
}

TEST_F(PeisEcologies, AKernelThatHasOnlyTheNameOfThisHostNeedsTrust) {
  transport::MemoryTransports elsewhere;
  elsewhere.join(world.net, "10.0.0.2");
  KernelPeer far(world.time, elsewhere, 101, 9000), near(world.time, world.machine, 103, 9003);
  const auto ecology = open({});
  const auto link = std::move(*ecology->join(kSelf));
  TupleSpace space(kSelf, world.time, *link);
  std::vector<std::string> sets;
  const auto policy = space.add_policy(*Pattern::parse("act"), [&](const RemoteSet& set) {
    sets.emplace_back(set.value);
    return SetDecision::applied();
  });
  far.connect(8000);
  near.connect(8000);
  world.run(1s);
  NetworkTuple set;
  set.owner = kSelf;
  set.key = "act";
  set.creator = kKernel;
  set.write_time = set.user_time = set.expire_time = WallTime{};
  set.encoding = Encoding::kAscii;
  set.media_type = "text/plain";
  set.data = "far";
  far.send(200, Port::kSetRemote, text_of(write_set_remote(set)));
  set.data = "near";
  near.send(200, Port::kSetRemote, text_of(write_set_remote(set)));
  world.run(1s);
  EXPECT_THAT(sets, ElementsAre("near"));
}

TEST_F(PeisEcologies, TwoEnginesAtOnceShowKernelsAllOwnKeys) {
  KernelPeer kernel(world, 101, 9000);
  kernel.listen();
  MemoryEcology memory(world.time);
  const auto peis = open(connected_to("127.0.0.1:9000"));
  joined::JoinedEcology both({{"memory", memory}, {"peis", *peis}}, world.time, log);
  const auto link = std::move(*both.join(kSelf));
  TupleSpace space(kSelf, world.time, *link);
  const auto tuple = *space.set("Only.Here", "1");
  world.run(2s);
  EXPECT_FALSE(space.has_subscriber(tuple)) << "the link itself is none";
  Subscribe subscribe;
  subscribe.prototype.key = "kernel.all-keys";
  kernel.send(200, Port::kSubscribe, text_of(write(subscribe)));
  world.run(100ms);
  const auto pushes = kernel.of(Port::kPush);
  ASSERT_THAT(pushes, ::testing::SizeIs(1));
  const auto push = *read_push(base::as_bytes(pushes[0].body));
  EXPECT_THAT(*push.data, EndsWith(c_string(" Only.Here)")));
}

TEST_F(PeisEcologies, KernelsAloneSeeTheKernelTuplesOfAComponentOfOurs) {
  KernelPeer kernel(world, 101, 9000);
  kernel.listen();
  const auto one = open(connected_to("127.0.0.1:9000"), "1"), two = open(connected_to("127.0.0.1:8000"), "2");
  const auto link = std::move(*one->join(kSelf)), other = std::move(*two->join(OwnerId{201}));
  TupleSpace space(kSelf, world.time, *link), reader(OwnerId{201}, world.time, *other);
  ASSERT_TRUE(space.set("a", "1"));
  std::vector<std::string> seen;
  const auto all = reader.subscribe({kSelf, "**"}, {}, [&](const Event& event) { seen.emplace_back(event.tuple.key); });
  world.run(3s);
  Subscribe subscribe;
  subscribe.prototype.owner = kSelf;
  subscribe.prototype.key = "kernel.id";
  kernel.send(number(kSelf), Port::kSubscribe, text_of(write(subscribe)));
  world.run(15s);
  EXPECT_THAT(kernel.of(Port::kPush), ::testing::SizeIs(1));
  EXPECT_THAT(seen, ElementsAre("a"));
  EXPECT_FALSE(space.get(kSelf, "kernel.id")) << "it has none itself";
}

/// Ends the link when a component comes.
struct Leaver final : LinkListener {
  void on_changes(OwnerId, std::span<const Change>) override {}
  void on_subscribe(OwnerId, const SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const RemoteSet&) override {}
  bool on_reply(OwnerId, const Reply&) override { return true; }
  void on_peer(const PeerIdentity&, PeerEvent) override { link.reset(); }
  void on_summary(OwnerId, std::string_view) override {}
  std::unique_ptr<Link> link;
};

TEST_F(PeisEcologies, ALinkMayEndInsideACall) {
  KernelPeer kernel(world, 101, 9000);
  kernel.listen();
  const auto ecology = open(connected_to("127.0.0.1:9000"));
  Leaver leaver;
  leaver.link = std::move(*ecology->join(kSelf));
  leaver.link->attach(leaver, 1);
  world.run(2s);
  EXPECT_EQ(leaver.link, nullptr);
  EXPECT_EQ(kernel.links(), 0u) << "it said goodbye";
}

TEST_F(PeisEcologies, ComponentsOfOursAgreeAfterABreakThatLastsLongerThanMessagesWait) {
  auto patient = connected_to("127.0.0.1:8000");
  patient.lease = 60s;
  PeisOptions listening;
  listening.lease = 60s;
  const auto one = open(listening, "1"), two = open(patient, "2");
  const auto owner_link = std::move(*one->join(OwnerId{1}));
  TupleSpace owner(OwnerId{1}, world.time, *owner_link);
  const auto reader_link = std::move(*two->join(OwnerId{2}));
  TupleSpace reader(OwnerId{2}, world.time, *reader_link);
  ASSERT_TRUE(owner.set("kept", "1"));
  ASSERT_TRUE(owner.set("deleted", "1"));
  const auto all = reader.subscribe(*Pattern::parse("**"), {}, [](const Event&) {});
  auto ended = reader.subscribe(*Pattern::parse("kept"), {}, [](const Event&) {});
  world.run(1s);
  world.net.tcp.stall(true);
  ASSERT_TRUE(owner.set("kept", "2"));
  ASSERT_TRUE(owner.erase("deleted"));
  ended.reset();
  world.run(40s);
  world.net.tcp.stall(false);
  world.run(40s);
  ASSERT_TRUE(reader.get(OwnerId{1}, "kept"));
  EXPECT_EQ(reader.get(OwnerId{1}, "kept")->value, "2");
  EXPECT_FALSE(reader.get(OwnerId{1}, "deleted"));
}

}  // namespace
}  // namespace rubicon::tuples::peis
