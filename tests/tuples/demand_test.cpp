#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

struct Demands : testing::Test, TwoComponents {
  DemandCall note() {
    return [this](const Demand& demand) {
      seen.push_back(std::string(demand.key) + (demand.wanted ? " on " : " off ") +
                     std::to_string(demand.interval / 1ms));
    };
  }
  Seen turn() {
    time.run_ready();
    return std::exchange(seen, {});
  }
  Seen seen;
};

TEST_F(Demands, ComesWithTheFirstAndGoesWithTheLastSubscriber) {
  ASSERT_TRUE(island->space.declare("a.v"));
  const auto watch = island->space.watch_demand(pattern("*.v"), note());
  EXPECT_THAT(turn(), IsEmpty());
  auto far = robot->space.subscribe(pattern("a.*"), {}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a.v on 0"));
  auto near = island->space.subscribe(pattern("**"), {}, [](const Event&) {});
  EXPECT_THAT(turn(), IsEmpty());
  far.reset();
  EXPECT_THAT(turn(), IsEmpty());
  near.reset();
  EXPECT_THAT(turn(), ElementsAre("a.v off 0"));
}

TEST_F(Demands, PassiveSubscribersCreateNone) {
  ASSERT_TRUE(island->space.declare("a"));
  const auto watch = island->space.watch_demand(pattern("a"), note());
  const auto far = robot->space.subscribe(pattern("a"), {.passive = true}, [](const Event&) {});
  const auto near = island->space.subscribe(pattern("a"), {.passive = true}, [](const Event&) {});
  EXPECT_THAT(turn(), IsEmpty());
  EXPECT_TRUE(island->space.has_subscriber(*island->space.find("a")));
}

TEST_F(Demands, TheShortestIntervalCountsAndZeroIsShortest) {
  ASSERT_TRUE(island->space.declare("a"));
  const auto watch = island->space.watch_demand(pattern("a"), note());
  const auto slow = robot->space.subscribe(pattern("a"), {.minimum = 5s}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a on 5000"));
  auto fast = island->space.subscribe(pattern("a"), {.minimum = 1s}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a on 1000"));
  auto any = robot->space.subscribe(pattern("a"), {}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a on 0"));
  any.reset();
  fast.reset();
  EXPECT_EQ(turn().back(), "a on 5000");
}

TEST_F(Demands, FutureTuplesAreWantedFromTheirBirth) {
  const auto watch = island->space.watch_demand(pattern("**"), note());
  const auto far = robot->space.subscribe(pattern("a.*"), {.minimum = 2s}, [](const Event&) {});
  EXPECT_THAT(turn(), IsEmpty());
  ASSERT_TRUE(island->space.declare("a.b"));
  EXPECT_THAT(turn(), ElementsAre("a.b on 2000"));
  ASSERT_TRUE(island->space.erase("a.b"));
  EXPECT_THAT(turn(), ElementsAre("a.b off 0"));
}

TEST_F(Demands, AWatchIsToldWhatIsWantedAlready) {
  ASSERT_TRUE(island->space.declare("a"));
  ASSERT_TRUE(island->space.declare("b"));
  const auto far = robot->space.subscribe(pattern("a"), {}, [](const Event&) {});
  turn();
  const auto watch = island->space.watch_demand(pattern("*"), note());
  EXPECT_THAT(turn(), ElementsAre("a on 0"));
}

TEST_F(Demands, AWatchIsToldOnceOfASubscriptionThatBeginsInTheSameTurn) {
  ASSERT_TRUE(island->space.declare("a"));
  turn();
  const auto watch = island->space.watch_demand(pattern("a"), note());
  const auto near = island->space.subscribe(pattern("a"), {}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a on 0"));
}

TEST_F(Demands, ChangesWithinATurnAreMerged) {
  ASSERT_TRUE(island->space.declare("a"));
  const auto watch = island->space.watch_demand(pattern("a"), note());
  turn();
  for (int i = 0; i < 5; ++i) {
    auto brief = island->space.subscribe(pattern("a"), {}, [](const Event&) {});
  }
  EXPECT_THAT(turn(), IsEmpty());
}

TEST_F(Demands, GoesWithALostPeerAndComesBackWithIt) {
  ASSERT_TRUE(island->space.declare("a"));
  const auto watch = island->space.watch_demand(pattern("a"), note());
  const auto far = robot->space.subscribe(pattern("a"), {}, [](const Event&) {});
  EXPECT_THAT(turn(), ElementsAre("a on 0"));
  ecology.cut(kIsland, kRobot);
  EXPECT_THAT(turn(), ElementsAre("a off 0"));
  ecology.mend(kIsland, kRobot);
  EXPECT_THAT(turn(), ElementsAre("a on 0"));
  robot.reset();
  EXPECT_THAT(turn(), ElementsAre("a off 0"));
}

TEST_F(Demands, AWatchMayEndItself) {
  ASSERT_TRUE(island->space.declare("a"));
  ASSERT_TRUE(island->space.declare("b"));
  Handle watch;
  int calls = 0;
  watch = island->space.watch_demand(pattern("*"), [&](const Demand&) { ++calls, watch.reset(); });
  const auto far = robot->space.subscribe(pattern("*"), {}, [](const Event&) {});
  turn();
  EXPECT_EQ(calls, 1);
}

/// 10,000 random steps of three components; the demand told so far is always what a plain union says.
struct RandomDemand {
  struct Subscribed {
    Pattern what;
    Flow flow;
    Handle handle;
  };

  RandomDemand() {
    watch = two.island->space.watch_demand(pattern("**"), [this](const Demand& demand) {
      if (demand.wanted) {
        told[std::string(demand.key)] = demand.interval;
      } else {
        told.erase(std::string(demand.key));
      }
    });
  }

  std::size_t roll(std::size_t sides) { return std::uniform_int_distribution<std::size_t>(0, sides - 1)(dice); }
  std::string key(bool wild) {
    static const char* const parts[] = {"a", "b", "c", "*"};
    std::string text;
    const auto count = 1 + roll(4);
    for (std::size_t i = 0; i < count; ++i) text += (i ? "." : "") + std::string(parts[roll(wild ? 4 : 3)]);
    if (wild && roll(4) == 0) text += ".**";
    return text;
  }

  void step() {
    const auto choice = roll(100);
    if (choice < 30) {
      auto& space = roll(2) == 0 ? two.island->space : roll(2) == 0 ? two.robot->space : third.space;
      Pattern what = pattern((roll(2) == 0 ? "1:" : "*:") + key(true));
      const Flow flow{.minimum = std::chrono::seconds(roll(3)), .passive = roll(4) == 0};
      subscribed.push_back({what, flow, space.subscribe(what, flow, [](const Event&) {})});
    } else if (choice < 60) {
      if (!subscribed.empty())
        subscribed.erase(subscribed.begin() + static_cast<std::ptrdiff_t>(roll(subscribed.size())));
    } else if (choice < 85) {
      const auto name = key(false);
      ASSERT_TRUE(two.island->space.declare(name));
      own.insert(name);
    } else if (choice < 97) {
      const auto name = key(false);
      EXPECT_EQ(two.island->space.erase(name).has_value(), own.erase(name) == 1);
    } else {
      const auto what = pattern(key(true));
      two.island->space.erase(what);
      std::erase_if(own, [&](const std::string& name) { return what.matches(two.kIsland, name); });
    }
  }

  std::map<std::string, Duration> expected() const {
    std::map<std::string, Duration> wanted;
    for (const auto& name : own) {
      for (const auto& s : subscribed) {
        if (s.flow.passive || !s.what.matches(two.kIsland, name)) continue;
        const auto [found, fresh] = wanted.try_emplace(name, s.flow.minimum);
        if (!fresh) found->second = std::min(found->second, s.flow.minimum);
      }
    }
    return wanted;
  }

  TwoComponents two;
  Component third{two.ecology, two.time, 80000};
  std::mt19937 dice{20260101};
  std::vector<Subscribed> subscribed;
  std::set<std::string> own;
  std::map<std::string, Duration> told;
  Handle watch;
};

TEST(DemandAtRandom, IsAlwaysTheUnionOfTheLiveSubscriptions) {
  RandomDemand random;
  for (int i = 0; i < 10'000; ++i) {
    random.step();
    if (i % 7 != 0) continue;
    random.two.time.run_ready();
    ASSERT_EQ(random.told, random.expected()) << "after step " << i;
  }
  random.subscribed.clear();
  random.two.time.run_ready();
  EXPECT_TRUE(random.told.empty());
  EXPECT_EQ(random.two.island->space.stats().subscriptions, 0u);
}

}  // namespace
}  // namespace rubicon::tuples
