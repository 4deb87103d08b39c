#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/joined/joined_link.h"
#include "tuples/link.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::tuples::joined {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr OwnerId kIsland{1}, kTool{70000}, kRobot{70001};
constexpr const char *kHere = "here", *kThere = "there";

/// An island on the folder of its host (`host`) and on a LAN (`dds`).
struct OnThisHost : testing::Test {
  struct Member {
    Member(Ecology& ecology, Scheduler& time, OwnerId id)
        : link(std::move(*ecology.join(id))), space(id, time, *link) {}
    std::unique_ptr<Link> link;
    TupleSpace space;
  };
  OnThisHost() {
    lan.certify(kTool, {.name = "lan"});  // of another process
    policy = island.space.add_policy(*Pattern::parse("lamp"), [](const RemoteSet&) { return SetDecision::applied(); });
    EXPECT_TRUE(island.space.set("lamp", "off"));
  }
  Reply set(TupleSpace& space) {
    Reply answer;
    space.set_remote(kIsland, "lamp", "on", 5s, [&](const Reply& reply) { answer = reply; });
    time.run_for(10s);
    return answer;
  }

  VirtualScheduler time;
  support::CollectingLog log;
  MemoryEcology host{time, kHere}, lan{time, kThere};
  JoinedEcology joined{std::vector<JoinedEcology::Engine>{{"host", host}, {"dds", lan}}, time, log, kThere};
  Member island{joined, time, kIsland};
  Handle policy;
};

/// Its presence on the LAN claims the host of the island.
TEST_F(OnThisHost, WhoClaimsToBeHereByDdsAloneIsIgnoredAndNamed) {
  Member liar(lan, time, kTool);
  const auto all = liar.space.subscribe({kIsland, "**"}, {}, [](const Event&) {});
  time.run_for(1s);
  EXPECT_THAT(island.space.peers(), IsEmpty());
  const auto refused = set(liar.space);
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_THAT(refused.text, HasSubstr("component 70000 says that it is of this host, but did not come to its folder"));
  EXPECT_EQ(island.space.get(kIsland, "lamp")->value, "off");
  EXPECT_THAT(log.lines, ElementsAre(HasSubstr("component 70000 says by dds that it is of this host")));
}

TEST_F(OnThisHost, WhoIsOnBothLivesInTheFolder) {
  JoinedEcology both{std::vector<JoinedEcology::Engine>{{"host", host}, {"dds", lan}}, time, log, kThere};
  Member tool(both, time, kTool);
  time.run_for(10s);
  EXPECT_THAT(island.space.peers(), ElementsAre(kTool));
  EXPECT_EQ(set(tool.space).verdict, Verdict::kApplied);
  EXPECT_THAT(log.lines, IsEmpty());
}

PeerIdentity by_word(std::uint64_t start) {
  return {kRobot, start, kThere};
}
PeerIdentity by_user(std::uint64_t start) {
  auto one = by_word(start);
  one.member = std::make_shared<const tuples::Member>(tuples::Member{.name = "robot"});
  return one;
}
PeerIdentity by_kernel(std::uint64_t start) {
  auto one = by_word(start);
  one.by_kernel = true;
  return one;
}

constexpr std::size_t kOnHost = 0, kOnDds = 1, kOnPeis = 2;

TEST(ProofOfAWire, ABetterOneTakesOverAndALowerOneNeverDoes) {
  MetPeer peer(3);
  EXPECT_EQ(peer.meet(kOnPeis, by_word(7)).up, kOnPeis);
  EXPECT_EQ(peer.meet(kOnDds, by_user(5)).up, kOnDds);
  const auto moved = peer.meet(kOnHost, by_kernel(3));
  EXPECT_EQ(moved.up, kOnHost);
  EXPECT_EQ(moved.down->incarnation, 5U);
  EXPECT_TRUE(peer.is_resident(kOnHost));
  EXPECT_FALSE(peer.is_resident(kOnDds)) << "another start, and less proof";
  // A later start of the same host, by its own word, is no reason to move.
  EXPECT_FALSE(peer.part(kOnPeis, PeerEvent::kLost).up);
  EXPECT_FALSE(peer.meet(kOnPeis, by_word(99)).up);
  EXPECT_EQ(peer.home(), kOnHost);
}

TEST(ProofOfAWire, WhenTheBestIsGoneTheNextBestCounts) {
  MetPeer peer(3);
  peer.meet(kOnHost, by_kernel(3));
  peer.meet(kOnPeis, by_word(3));
  peer.meet(kOnDds, by_user(9));
  EXPECT_EQ(peer.part(kOnHost, PeerEvent::kLost).up, kOnDds);
  EXPECT_EQ(peer.part(kOnDds, PeerEvent::kLost).up, kOnPeis);
}

/// The kernel vouches for its carrier, not for whom it stands for.
TEST(ProofOfAWire, AStandInHasNone) {
  MetPeer peer(3);
  auto stand_in = by_kernel(3);
  stand_in.host = marked_host(kThere, OwnerId(2));
  peer.meet(kOnHost, stand_in);
  EXPECT_EQ(peer.meet(kOnDds, by_word(3)).up, kOnDds);
  MetPeer own(3);
  stand_in.own_process = true;  // as other components of its carrier's process meet it
  own.meet(kOnHost, stand_in);
  EXPECT_EQ(own.meet(kOnDds, by_word(3)).up, kOnDds);
}

}  // namespace
}  // namespace rubicon::tuples::joined
