#include <ostream>

#include "tuples/carry/wires.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// From the wire of the owner to that of the reader.
struct Pair {
  std::string near, far;
};
void PrintTo(const Pair& pair, std::ostream* out) {
  *out << pair.near << " to " << pair.far;
}

/// A home (7) on one wire, a reader (8) on the other one; an island (1) on both carries the home. Each in a process of
/// its own.
struct BetweenWires : testing::TestWithParam<Pair> {
  void SetUp() override {
    time.run_for(20s);
    seen.take();
    reader()->take();
    home()->take();
  }
  template <class Member = Observer>
  std::unique_ptr<Site<Member>> site(std::uint32_t id, const typename Site<Member>::On& on,
                                     const CarryRules& rules = {}) {
    time.run_for(1s);
    return std::make_unique<Site<Member>>(time, log, id, on, rules);
  }
  std::unique_ptr<Site<>> carrier(std::uint32_t id) {
    return site(id, {{GetParam().near, near.get()}, {GetParam().far, far.get()}}, rules_of({"7"}));
  }
  Site<Home>& home() { return *home_; }
  Site<>& reader() { return *reader_; }
  /// Long enough for stand-ins to begin, whatever the wire.
  void settle() { time.run_for(5s); }
  Reply set(std::string_view key, std::string_view value, Duration lives = 10s) {
    Reply answer{{}, 0, Verdict::kExpired, {}, "none", 0};
    reader()->space.set_remote(OwnerId(7), key, value, lives, [&](const Reply& reply) { answer = reply; });
    time.run_for(5s);
    return answer;
  }

  VirtualScheduler time;
  support::CollectingLog log;
  std::unique_ptr<Wire> near = make_wire(GetParam().near, time, log), far = make_wire(GetParam().far, time, log);
  std::unique_ptr<Site<>> island = carrier(1);
  std::unique_ptr<Site<Home>> home_ = site<Home>(7, {{GetParam().near, near.get()}});
  std::unique_ptr<Site<>> reader_ = site(8, {{GetParam().far, far.get()}});
  Listener seen;
};

TEST_P(BetweenWires, TheOtherOneHasAStandInAndTheCarrierSeesNone) {
  EXPECT_THAT(reader()->space.peers(), ElementsAre(OwnerId(1), OwnerId(7)));
  EXPECT_THAT(home()->space.peers(), ElementsAre(OwnerId(1))) << "the reader is not carried";
  EXPECT_EQ(island->stand_ins(), 1U);
  EXPECT_THAT((*island)->take(), testing::UnorderedElementsAre("7 up", "8 up"));
}

TEST_P(BetweenWires, ValuesPass) {
  const auto handle = reader()->space.subscribe(pattern("7:*.lamp"), {}, seen.call());
  settle();
  EXPECT_THAT(seen.take(), testing::UnorderedElementsAre("kitchen.lamp=off", "hall.lamp=off"));
  ASSERT_TRUE(home()->space.set("hall.lamp", "on"));
  time.run_for(1s);
  const auto copy = *reader()->space.get(OwnerId(7), "hall.lamp"), own = *home()->space.get(OwnerId(7), "hall.lamp");
  EXPECT_EQ(copy.sequence, own.sequence);
  EXPECT_EQ(copy.creator, own.creator);
  ASSERT_TRUE(home()->space.erase("hall.lamp"));
  time.run_for(1s);
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=on", "hall.lamp deleted"));
}

TEST_P(BetweenWires, WhoLooksMakesTheOwnerMeasure) {
  auto handle = std::make_optional(reader()->space.subscribe(pattern("7:kitchen.lamp"), {.minimum = 2s}, seen.call()));
  settle();
  EXPECT_TRUE(home()->demand.wanted);
  EXPECT_EQ(home()->demand.interval, 2s);
  EXPECT_THAT(home()->space.peers(), ElementsAre(OwnerId(1), OwnerId(8))) << "the owner sees who looks";
  handle.reset();
  time.run_for(1s);
  EXPECT_FALSE(home()->demand.wanted);
  time.run_for(20s);
  EXPECT_THAT(home()->space.peers(), ElementsAre(OwnerId(1)));
}

TEST_P(BetweenWires, TheOwnerDecidesAboutRemoteSetsOfTheReader) {
  EXPECT_EQ(set("hall.lamp", "on").verdict, Verdict::kApplied);
  ASSERT_EQ(home()->sets.size(), 1U);
  EXPECT_EQ(home()->sets[0].from, OwnerId(8));
  const auto refused = set("hall.lamp", "bad");
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_EQ(refused.text, "no such word");
  EXPECT_EQ(home()->sets.size(), 2U) << "once each";
}

TEST_P(BetweenWires, AStandInEndsWithItsComponentAndBeginsAgain) {
  const auto handle = reader()->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  settle();
  home_.reset();
  time.run_for(1s);
  EXPECT_THAT(reader()->take(), ElementsAre("7 left"));
  home_ = site<Home>(7, {{GetParam().near, near.get()}});
  ASSERT_TRUE(home()->space.set("hall.lamp", "again"));
  time.run_for(20s);
  EXPECT_THAT(reader()->take(), ElementsAre("7 up"));
  EXPECT_THAT(seen.take(), Contains("hall.lamp=again"));
}

TEST_P(BetweenWires, TheComponentItselfTakesThePlaceOfItsStandIn) {
  const auto handle = reader()->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  settle();
  home_.reset();
  home_ = site<Home>(7, {{GetParam().near, near.get()}, {GetParam().far, far.get()}});
  ASSERT_TRUE(home()->space.set("hall.lamp", "mine"));
  time.run_for(60s);
  EXPECT_THAT(reader()->space.peers(), ElementsAre(OwnerId(1), OwnerId(7)));
  EXPECT_EQ(reader()->value(7, "hall.lamp"), "mine");
  EXPECT_EQ(set("hall.lamp", "on").verdict, Verdict::kApplied);
  EXPECT_EQ(island->stand_ins(), 0U);
}

/// A second carrier behind the wire of the reader.
TEST_P(BetweenWires, StandInsAreNeverCarriedOn) {
  TwinWire third(time);
  const auto next = site(2, {{GetParam().far, far.get()}, {"third", &third}}, rules_of({"**"}));
  const auto end = site(9, {{"third", &third}});
  const auto handle = reader()->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  time.run_for(60s);
  EXPECT_THAT((*end)->take(), testing::UnorderedElementsAre("2 up", "1 up", "8 up")) << "who is met there itself";
  EXPECT_THAT(home()->space.peers(), Not(Contains(OwnerId(9))));
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
}

TEST_P(BetweenWires, OfTwoCarriersOneCarriesAndTheOtherTakesOverWhenItIsKilled) {
  const auto second = carrier(2);
  const auto handle = reader()->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  time.run_for(20s);
  EXPECT_EQ(island->stand_ins(), 2U);
  EXPECT_EQ(second->stand_ins(), 0U);
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  island->kill();
  island.reset();
  time.run_for(40s);
  EXPECT_EQ(second->stand_ins(), 2U);
  EXPECT_THAT(log.lines, Not(Contains(HasSubstr("with other rules"))));
  ASSERT_TRUE(home()->space.set("hall.lamp", "on"));
  time.run_for(1s);
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=on"));
  EXPECT_EQ(set("hall.lamp", "dim").verdict, Verdict::kApplied);
  EXPECT_EQ(home()->sets.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Engines, BetweenWires,
                         testing::Values(Pair{"host", "mqtt"}, Pair{"mqtt", "host"}, Pair{"dds", "mqtt"},
                                         Pair{"mqtt", "dds"}, Pair{"host", "dds"}, Pair{"dds", "host"},
                                         Pair{"dds", "peis"}, Pair{"peis", "dds"}),
                         [](const auto& one) { return one.param.near + "_" + one.param.far; });

}  // namespace
}  // namespace rubicon::tuples::carry
