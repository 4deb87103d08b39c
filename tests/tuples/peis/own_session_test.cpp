#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/peis_ecology.h"
#include "tuples/peis/peis_world.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::Le;

/// Writes down what a link brings.
struct NotingListener final : LinkListener {
  void on_changes(OwnerId, std::span<const Change> changes) override {
    for (const auto& change : changes) {
      if (const auto* set = std::get_if<TupleSet>(&change)) creators.push_back(number(set->tuple.creator));
    }
  }
  void on_subscribe(OwnerId, const SubscriptionSpec& spec) override { subscribed.push_back(spec.id); }
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const RemoteSet&) override {}
  bool on_reply(OwnerId, const Reply&) override { return true; }
  void on_peer(const PeerIdentity&, PeerEvent) override {}
  void on_summary(OwnerId, std::string_view summary) override { summaries.emplace_back(summary); }

  std::vector<std::uint32_t> creators, subscribed;
  std::vector<std::string> summaries;
};

class TwoLinksOfOurs : public ::testing::Test {
 protected:
  TwoLinksOfOurs() {
    PeisOptions listening, connecting;
    listening.multicast = connecting.multicast = false;
    listening.lease = connecting.lease = 60s;
    connecting.connect = {"127.0.0.1:8000"};
    one = open(listening, "1");
    two = open(connecting, "2");
    owner = std::move(*one->join(kOwner));
    reader = std::move(*two->join(kReader));
    owner->attach(owner_notes, 1);
    reader->attach(reader_notes, 1);
    world.run(2s);
  }
  std::unique_ptr<PeisEcology> open(const PeisOptions& options, const std::string& process) {
    const PeisMachine machine{world.interfaces, "hostx", "host-of-hostx", process, "anna"};
    return std::move(*PeisEcology::open(options, world.time, world.machine, world.sink, machine));
  }

  static constexpr OwnerId kOwner{1}, kReader{2};
  PeisWorld world;
  NotingListener owner_notes, reader_notes;
  std::unique_ptr<PeisEcology> one, two;
  std::unique_ptr<Link> owner, reader;
};

TEST_F(TwoLinksOfOurs, ACreatorWithAnIdThatPeisDoesNotHaveIsTheOwner) {
  TupleSet set;
  set.tuple.owner = kOwner;
  set.tuple.key = "a";
  set.tuple.value = "1";
  set.tuple.sequence = 1;
  std::vector<Change> changes;
  for (const auto creator : {OwnerId{0x90000000}, OwnerId{7}}) {
    set.tuple.creator = creator;
    changes.emplace_back(set);
  }
  EXPECT_TRUE(owner->publish(kReader, changes));
  world.run(100ms);
  EXPECT_THAT(reader_notes.creators, ElementsAre(1, 7));
}

TEST_F(TwoLinksOfOurs, SummariesAndSubscriptionsThatWaitReplaceEachOther) {
  world.net.tcp.stall(true);
  for (int i = 0; i < 1000; ++i) owner->describe(std::to_string(i) + std::string(16'000, 's'));
  for (int i = 0; i < 20'000; ++i) reader->subscribe({1 + static_cast<std::uint32_t>(i % 10), {kOwner, "a"}, {}});
  world.run(1s);
  world.net.tcp.stall(false);
  world.run(30s);
  EXPECT_THAT(reader_notes.summaries.size(), AllOf(Ge(1u), Le(400u)));
  EXPECT_EQ(reader_notes.summaries.back().substr(0, 4), "999s");
  EXPECT_THAT(owner_notes.subscribed.size(), AllOf(Ge(10u), Le(15'000u)));
  EXPECT_THAT(std::vector(owner_notes.subscribed.end() - 10, owner_notes.subscribed.end()),
              ::testing::UnorderedElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
}

}  // namespace
}  // namespace rubicon::tuples::peis
