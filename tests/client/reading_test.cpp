#include "client/client_parts.h"

namespace rubicon::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_F(ClientParts, AReadingEndsWhenAllIsHere) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(island->space.set("a.t" + std::to_string(i), "x"));
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a.*"}, keep, 3s);
  time.run_for(kDdsPace.quiet - 1ms);
  EXPECT_EQ(times, 0) << "somebody may still come";
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 3U);
  time.run_for(10s);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(self.space.stats().subscriptions, 0U);
}

TEST_F(ClientParts, AReadingKeepsWhatIsWanted) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(island->space.set("a.t" + std::to_string(i), std::to_string(i)));
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a.*"}, keep, 3s, {},
                         [](const TupleView& tuple) { return tuple.value == "1"; });
  time.run_for(kDdsPace.quiet + 1ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].key, "a.t1");
}

TEST_F(ClientParts, OnPeisAReadingWaitsUntilKernelsHadTimeToAppear) {
  PeerDiscovery search{time, self.space, kPeisPace};
  ASSERT_TRUE(island->space.set("a", "x"));
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kPeisPace.search - 1ms);
  EXPECT_EQ(times, 0) << "a kernel announces itself each second";
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
}

/// The first component of a process may come long before the next one by DDS.
TEST_F(ClientParts, AReadingWaitsForComponentsThatAreOnTheirWay) {
  bool expected = true;
  PeerDiscovery search{time, self.space, kDdsPace, [&](auto) { return expected; }};
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kDdsPace.expected - 100ms);
  EXPECT_EQ(times, 0);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(1ms);
  expected = false;
  time.run_for(kDdsPace.quiet + 21ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
}

TEST_F(ClientParts, AReadingDoesNotWaitForeverForThem) {
  PeerDiscovery search{time, self.space, kDdsPace, [](auto) { return true; }};
  const TupleQuery query(time, self.space, search, {std::nullopt, "a"}, keep, 3s);
  time.run_for(kDdsPace.expected - 1ms);
  EXPECT_EQ(times, 0);
  time.run_for(2ms);
  EXPECT_EQ(times, 1);
}

/// A stop of this process may end the lease of a component that it has just met.
TEST_F(ClientParts, AReadingWaitsForTheComponentThatWasLost) {
  ASSERT_TRUE(island->space.set("a", "x"));
  time.run_for(100ms);
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 10s);
  ecology.cut(OwnerId(1), OwnerId(70000));
  time.run_for(3900ms);
  EXPECT_EQ(times, 0);
  ASSERT_TRUE(island->space.set("a", "again"));
  ecology.mend(OwnerId(1), OwnerId(70000));
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_EQ(times, 1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].value, "again");
}

TEST_F(ClientParts, AStopWhileALostComponentIsAwaitedUsesUpNoPatience) {
  time.run_for(100ms);
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 10s);
  ecology.cut(OwnerId(1), OwnerId(70000));
  time.run_for(2s);
  time.stop_for(20s);
  time.run_for(100ms);
  EXPECT_EQ(times, 0);
  time.run_for(2s);
  EXPECT_EQ(times, 1);
}

/// As in a virtual machine that gets no processor for a while: what others sent meanwhile is taken afterwards.
TEST_F(ClientParts, AStopOfThisProcessIsNoTimeInWhichNobodyCame) {
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s);
  time.run_for(100ms);
  time.stop_for(20s);
  time.run_for(100ms);
  EXPECT_EQ(times, 0);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
}

TEST_F(ClientParts, AStopBeforeAReadingIsNone) {
  time.stop_for(20s);
  EXPECT_FALSE(peer_discovery.complete());
  time.run_for(kDdsPace.quiet + 1ms);
  EXPECT_TRUE(peer_discovery.complete());
  time.stop_for(20s);
  EXPECT_TRUE(peer_discovery.complete());
}

/// Is present and answers nothing.
struct Mute final : tuples::LinkListener {
  void on_changes(OwnerId, std::span<const tuples::Change>) override {}
  void on_subscribe(OwnerId, const tuples::SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const tuples::RemoteSet&) override {}
  bool on_reply(OwnerId, const tuples::Reply&) override { return true; }
  void on_peer(const tuples::PeerIdentity&, tuples::PeerEvent) override {}
  void on_summary(OwnerId, std::string_view) override {}
};

TEST_F(ClientParts, AReadingEndsWithoutThoseWhoDoNotAnswerAndSaysSo) {
  ASSERT_TRUE(island->space.set("a", "x"));
  Mute mute;
  const auto link = std::move(*ecology.join(OwnerId(2)));
  link->attach(mute, 1);
  std::vector<OwnerId> left_out;
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s,
                         [&](const std::vector<OwnerId>& owners) { left_out = owners; });
  time.run_for(1s);
  time.stop_for(20s);
  time.run_for(1800ms);
  EXPECT_EQ(times, 0) << "a stop of this process is a moment of the patience";
  time.run_for(300ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(found.size(), 1U);
  EXPECT_THAT(left_out, ElementsAre(OwnerId(2)));
}

TEST_F(ClientParts, AReadingOfOneOwnerWaitsForNobodyElse) {
  ASSERT_TRUE(island->space.set("a", "x"));
  time.run_ready();
  const TupleQuery query(time, self.space, peer_discovery, {kIsland, "a"}, keep, 3s);
  time.run_for(1ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].value, "x");
}

TEST_F(ClientParts, AReadingWaitsForAnOwnerThatIsNamedAsLongAsItsPatience) {
  EXPECT_EQ(peer_discovery.has(OwnerId(7)), std::nullopt);
  const TupleQuery query(time, self.space, peer_discovery, {OwnerId(7), "a"}, keep, 10s);
  time.run_for(9900ms);
  EXPECT_EQ(times, 0);
  time.run_for(200ms);
  EXPECT_EQ(times, 1);
  EXPECT_THAT(found, IsEmpty());
  const TupleQuery again(time, self.space, peer_discovery, {OwnerId(7), "b"}, keep, 10s);
  time.run_for(1ms);
  EXPECT_EQ(times, 2) << "it had its time";
}

TEST_F(ClientParts, AReadingTakesTheOwnerThatComesLate) {
  const TupleQuery query(time, self.space, peer_discovery, {OwnerId(7), "a"}, keep, 10s);
  time.run_for(8s);
  Member late(ecology, time, 7);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(1ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].value, "late");
}

/// The folder of a host knows who is there.
TEST_F(ClientParts, OnAHostThatAnOwnerIsNotThereIsKnownAtOnce) {
  bool expected = true;
  PeerDiscovery search{time, self.space, kHostPace, [&](auto) { return expected; }};
  const TupleQuery query(time, self.space, search, {OwnerId(7), "a"}, keep, 10s);
  const TupleQuery of_all(time, self.space, search, {std::nullopt, "a"}, keep, 10s);
  time.run_for(100ms);
  EXPECT_EQ(times, 0);
  EXPECT_EQ(search.has(OwnerId(7)), std::nullopt);
  expected = false;
  time.run_for(2ms);
  EXPECT_EQ(times, 2);
  EXPECT_EQ(search.has(OwnerId(7)), std::optional(false));
  EXPECT_EQ(search.has(OwnerId(1)), std::optional(true));
}

TEST_F(ClientParts, AReadingCreatesNoDemand) {
  std::vector<std::string> wanted;
  ASSERT_TRUE(island->space.set("a", "x"));
  const auto watch = island->space.watch_demand({std::nullopt, "**"}, [&](const tuples::Demand& demand) {
    if (demand.wanted) wanted.emplace_back(demand.key);
  });
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "**"}, keep, 3s);
  time.run_for(5s);
  EXPECT_EQ(found.size(), 1U);
  EXPECT_THAT(wanted, IsEmpty());
}

TEST_F(ClientParts, ANewcomerDuringTheReadingIsWaitedFor) {
  const TupleQuery query(time, self.space, peer_discovery, {std::nullopt, "a"}, keep, 3s);
  time.run_for(200ms);
  Member late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "late"));
  time.run_for(200ms);
  EXPECT_EQ(times, 0);
  time.run_for(101ms);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].owner, OwnerId(2));
}

}  // namespace
}  // namespace rubicon::client
