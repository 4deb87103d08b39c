#include "tuples/carry/carrying.h"
#include "tuples/peis/link_to_a_kernel.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using joined::Observer;
using peis::KernelPeer;
using peis::PeisEcology;
using testing::Contains;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

/// An island (1) that carries between an engine in memory and PEIS with one kernel (101).
struct PeisTwin : testing::Test {
  std::unique_ptr<PeisEcology> open(const std::string& process, const std::string& connect) {
    peis::PeisOptions options;
    options.multicast = false;
    options.connect = {connect};
    const peis::PeisMachine machine{world.interfaces, "hostx", "host-of-hostx", process, "anna"};
    return std::move(*PeisEcology::open(options, world.time, world.machine, log, machine));
  }
  void SetUp() override {
    kernel.listen();
    world.run(1s);
    peis = open("1", "127.0.0.1:9000");
    carrier = std::make_unique<Carrier>(OwnerId(1), rules_of({"7", "101"}),
                                        std::vector<Carrier::Engine>{{"dds", dds}, {"peis", *peis}}, world.time, log);
    both = std::make_unique<joined::JoinedEcology>(
        std::vector<joined::JoinedEcology::Engine>{{"dds", carrier->engine(0)}, {"peis", carrier->engine(1)}},
        world.time, log);
    island = std::make_unique<Observer>(*both, world.time, 1);
    home = std::make_unique<Home>(dds, world.time, 7);
    world.run(10s);
  }
  void send(std::uint32_t to, peis::Port port, const Bytes& body) {
    kernel.send(to, port, peis::text_of(body));
    world.run(5s);
  }
  void subscribe(std::uint32_t to, std::string_view key) {
    peis::Subscribe out;
    out.prototype.owner = OwnerId(to);
    out.prototype.key = key;
    send(to, peis::Port::kSubscribe, write(out));
  }
  peis::NetworkTuple tuple(std::uint32_t owner, std::string_view key, std::string_view data) {
    peis::NetworkTuple out;
    out.owner = OwnerId(owner);
    out.creator = OwnerId(101);
    out.key = key;
    out.write_time = world.time.wall_now();
    out.user_time = out.expire_time = WallTime{};
    out.encoding = peis::Encoding::kAscii;
    out.media_type = "text/plain";
    out.data = data;
    out.sequence = 0;
    return out;
  }
  /// `key=data` of the pushes that the kernel received.
  std::vector<std::string> pushed() {
    std::vector<std::string> all;
    for (const auto& one : kernel.of(peis::Port::kPush)) {
      const auto read = *peis::read_push(base::as_bytes(one.body));
      all.push_back(std::to_string(number(*read.owner)) + ":" + std::string(read.key) + "=" +
                    std::string(read.data->substr(0, read.data->find('\0'))));
    }
    return all;
  }

  peis::PeisWorld world;
  support::CollectingLog log;
  KernelPeer kernel{world, 101, 9000};
  MemoryEcology dds{world.time, "host-of-hostx"};
  std::unique_ptr<PeisEcology> peis;
  std::unique_ptr<Carrier> carrier;
  std::unique_ptr<joined::JoinedEcology> both;
  std::unique_ptr<Observer> island;
  std::unique_ptr<Home> home;
};

TEST_F(PeisTwin, AKernelSeesSubscribesAndSetsAComponentOfTheOtherEngine) {
  EXPECT_TRUE(kernel.routable(7));
  EXPECT_THAT(home->space.peers(), ElementsAre(OwnerId(1), OwnerId(101)));
  EXPECT_THAT(std::string(home->space.summary(OwnerId(101))), HasSubstr("peis-kernel")) << "it is not an island";
  subscribe(7, "kitchen.lamp");
  EXPECT_THAT(pushed(), Contains("7:kitchen.lamp=off"));
  EXPECT_TRUE(home->demand.wanted);
  send(7, peis::Port::kSetRemote, write_set_remote(tuple(7, "kitchen.lamp", peis::c_string("on"))));
  EXPECT_EQ(home->value(7, "kitchen.lamp"), "on");
  ASSERT_THAT(home->sets, SizeIs(1));
  EXPECT_EQ(home->sets[0].from, OwnerId(101));
  EXPECT_THAT(pushed(), Contains("7:kitchen.lamp=on"));
}

TEST_F(PeisTwin, AKernelKnowsAllKeysThatAreCarried) {
  subscribe(7, "kernel.all-keys");
  EXPECT_THAT(pushed(), Contains(EndsWith(" hall.lamp kitchen.lamp kitchen.log)")));
  EXPECT_FALSE(home->demand.wanted);
}

TEST_F(PeisTwin, AKernelGetsNoListOfKeysThatLacksSome) {
  subscribe(7, "kernel.all-keys");
  std::vector<std::string> lists;
  for (const auto& push : pushed()) {
    if (push.starts_with("7:kernel.all-keys=")) lists.push_back(push);
  }
  EXPECT_THAT(lists, ElementsAre(EndsWith(" hall.lamp kitchen.lamp kitchen.log)")));
  ASSERT_TRUE(home->space.set("attic.lamp", "off"));
  world.run(5s);
  EXPECT_THAT(pushed(), Contains(HasSubstr(" attic.lamp hall.lamp "))) << "later ones are added";
}

TEST_F(PeisTwin, AKernelGetsOnlyWhatItSubscribedTo) {
  subscribe(7, "kernel.all-keys");
  subscribe(7, "hall.*");
  ASSERT_TRUE(home->space.set("kitchen.lamp", "later"));
  ASSERT_TRUE(home->space.set("hall.lamp", "on"));
  world.run(5s);
  EXPECT_THAT(pushed(), Contains("7:hall.lamp=on"));
  EXPECT_THAT(pushed(), Not(Contains(StartsWith("7:kitchen."))));
}

TEST_F(PeisTwin, AKernelThatComesLaterSeesNoKeyThatWasDeletedMeanwhile) {
  subscribe(7, "kernel.all-keys");
  kernel.leave();
  world.run(30s);
  ASSERT_TRUE(home->space.erase("hall.lamp"));
  KernelPeer later{world, 101, 9000};
  later.listen();
  world.run(40s);
  peis::Subscribe out;
  out.prototype.owner = OwnerId(7);
  out.prototype.key = "kernel.all-keys";
  later.send(7, peis::Port::kSubscribe, peis::text_of(write(out)));
  world.run(10s);
  const auto pushes = later.of(peis::Port::kPush);
  ASSERT_FALSE(pushes.empty());
  EXPECT_THAT(std::string(*peis::read_push(base::as_bytes(pushes.back().body))->data),
              HasSubstr(" kitchen.lamp kitchen.log)"));
  EXPECT_THAT(std::string(*peis::read_push(base::as_bytes(pushes.back().body))->data), Not(HasSubstr("hall.lamp")));
}

TEST_F(PeisTwin, TheOtherEngineReadsAndSetsAKernel) {
  Listener seen;
  const auto handle = home->space.subscribe(pattern("101:x"), {}, seen.call());
  world.run(5s);
  ASSERT_THAT(kernel.of(peis::Port::kSubscribe), testing::Not(testing::IsEmpty()));
  EXPECT_EQ(number(kernel.of(peis::Port::kSubscribe).back().header.source), 7U);
  const auto data = peis::c_string("42");
  auto push = tuple(101, "x", data);
  push.sequence = 3;
  send(7, peis::Port::kPush, write_push(push));
  EXPECT_THAT(seen.take(), ElementsAre("x=42"));
  EXPECT_EQ(home->space.get(OwnerId(101), "x")->sequence, 4U);
  Reply answer;
  home->space.set_remote(OwnerId(101), "x", "43", 5s, [&](const Reply& reply) { answer = reply; });
  world.run(2s);
  EXPECT_THAT(answer.text, HasSubstr("the PEIS kernel does not say whether it was accepted"));
  ASSERT_THAT(kernel.of(peis::Port::kSetRemote), SizeIs(1));
  EXPECT_EQ(peis::read_set_remote(base::as_bytes(kernel.of(peis::Port::kSetRemote)[0].body))->creator, OwnerId(7));
}

TEST_F(PeisTwin, AKernelThatIsKilledLosesItsStandIn) {
  subscribe(7, "kitchen.lamp");
  ASSERT_TRUE(home->demand.wanted);
  kernel.leave();
  world.run(30s);
  EXPECT_FALSE(home->demand.wanted);
  EXPECT_THAT(home->space.peers(), ElementsAre(OwnerId(1)));
}

TEST_F(PeisTwin, TheComponentItselfDisplacesItsStandInAndStays) {
  std::vector<OwnerId> displaced;
  const auto other = open("2", "127.0.0.1:8000");
  other->watch_displaced([&](OwnerId id) { displaced.push_back(id); });
  const auto link = std::move(*other->join(OwnerId(7)));
  TupleSpace space(OwnerId(7), world.time, *link);
  ASSERT_TRUE(space.set("hall.lamp", "mine"));
  world.run(60s);
  EXPECT_THAT(displaced, SizeIs(0)) << "a stand-in ends no component";
  subscribe(7, "hall.lamp");
  EXPECT_THAT(pushed(), Contains("7:hall.lamp=mine"));
}

}  // namespace
}  // namespace rubicon::tuples::carry
