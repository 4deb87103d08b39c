#include "tuples/peis/routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr OwnerId kMiddle{50}, kLeft{101}, kRight{103}, kFar{200};
constexpr LinkId kLeftLink{1}, kRightLink{2};

class PeisRoutes : public ::testing::Test {
 protected:
  static RoutingPage page(std::vector<RouteEntry> entries) {
    RoutingPage page;
    page.entries = std::move(entries);
    return page;
  }
  static RouteEntry entry(OwnerId id, std::uint32_t sequence, std::uint8_t hops, std::uint32_t magic = 7) {
    return {id, sequence, magic, hops, 1};
  }
  RouteChanges hear(LinkId link, std::vector<RouteEntry> entries) { return routes.receive(link, page(entries), now); }
  void open_both() {
    routes.open(kLeftLink, kLeft, 11, 1, now);
    routes.open(kRightLink, kRight, 13, 1, now);
  }
  bool advertises(LinkId link, OwnerId id) const {
    for (const auto& offered : routes.entries_for(link, now)) {
      if (offered.id == id && offered.hops < kUnreachableMetric) return true;
    }
    return false;
  }

  NodeCounters counters;
  std::set<std::uint32_t> over;
  Routes routes{kMiddle, counters, [this](OwnerId, std::uint32_t magic) { return over.contains(magic); }};
  SteadyTime now{1h};
};

TEST_F(PeisRoutes, ANeighbourIsARouteAsLongAsItsLink) {
  EXPECT_THAT(routes.open(kLeftLink, kLeft, 11, 2, now).found, ElementsAre(kLeft));
  EXPECT_EQ(routes.find(kLeft)->metric, 2);
  EXPECT_TRUE(routes.find(kLeft)->direct);
  now += 1h;
  EXPECT_FALSE(routes.age(now).any());
  EXPECT_THAT(routes.close(kLeftLink, now).lost, ElementsAre(kLeft));
  EXPECT_EQ(routes.find(kLeft), nullptr);
}

TEST_F(PeisRoutes, AHostThatSpokeByWayOfANeighbourIsReachedThatWayUntilThePagesSayOtherwise) {
  open_both();
  EXPECT_THAT(routes.hear(kLeftLink, kFar, 7, 1, now).found, ElementsAre(kFar));
  EXPECT_EQ(routes.find(kFar)->metric, 2);
  EXPECT_FALSE(advertises(kRightLink, kFar)) << "its sequence is not known";
  EXPECT_FALSE(hear(kLeftLink, {}).any()) << "a page from before it";
  EXPECT_FALSE(hear(kLeftLink, {entry(kFar, 0xf0000000, 1)}).any());  // any sequence is the first
  EXPECT_TRUE(advertises(kRightLink, kFar));
  EXPECT_THAT(hear(kLeftLink, {}).lost, ElementsAre(kFar));
  EXPECT_FALSE(routes.hear(kLeftLink, kFar, 7, 1, now).any()) << "only a newer sequence brings it back: no loops";
  EXPECT_THAT(routes.hear(kLeftLink, kFar, 8, 1, now).found, ElementsAre(kFar)) << "another start";
  now += 21s;
  EXPECT_THAT(hear(kLeftLink, {}).lost, ElementsAre(kFar)) << "nobody lists it";
  EXPECT_THAT(routes.hear(kLeftLink, kFar, 8, 1, now).found, ElementsAre(kFar)) << "no sequence of it was known";
  now += 21s;
  hear(kLeftLink, {});
  over.insert(9);
  EXPECT_FALSE(routes.hear(kLeftLink, kFar, 9, 1, now).any()) << "a start that has ended";
}

TEST_F(PeisRoutes, WithTwoLinksToANeighbourTheOtherOneTakesOver) {
  open_both();
  routes.open(LinkId{3}, kLeft, 11, 1, now);
  hear(LinkId{3}, {entry(kFar, 1, 1)});
  EXPECT_FALSE(routes.close(LinkId{3}, now).any());
  EXPECT_EQ(routes.find(kLeft)->link, kLeftLink);
  EXPECT_EQ(routes.find(kFar)->link, kLeftLink);
}

TEST_F(PeisRoutes, TheShorterWayOfOneSequenceAndTheNewerSequenceWin) {
  open_both();
  EXPECT_THAT(hear(kLeftLink, {entry(kFar, 5, 3)}).found, ElementsAre(kFar));
  EXPECT_EQ(routes.find(kFar)->metric, 4);
  EXPECT_FALSE(hear(kRightLink, {entry(kFar, 5, 1)}).any());
  EXPECT_EQ(routes.find(kFar)->via, kRight);
  hear(kLeftLink, {entry(kFar, 4, 0)});
  EXPECT_EQ(routes.find(kFar)->via, kRight) << "an old sequence";
  hear(kLeftLink, {entry(kFar, 6, 3)});
  EXPECT_EQ(routes.find(kFar)->via, kRight) << "newer, but longer, and the shorter one is fresh";
  now += 30s;
  hear(kLeftLink, {entry(kFar, 9, 3)});
  EXPECT_EQ(routes.find(kFar)->via, kLeft) << "the shorter one has no news";
}

TEST_F(PeisRoutes, FromTenOnAHostIsUnreachable) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 9)});
  EXPECT_EQ(routes.find(kFar), nullptr);
  hear(kLeftLink, {entry(kFar, 5, 8)});
  EXPECT_NE(routes.find(kFar), nullptr);
  EXPECT_FALSE(hear(kRightLink, {entry(kFar, 5, 250)}).any()) << "it does not lead over that one";
  EXPECT_THAT(hear(kLeftLink, {entry(kFar, 5, 250)}).lost, ElementsAre(kFar));
}

TEST_F(PeisRoutes, WhatACompleteTableNoLongerListsIsLost) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 1), entry(OwnerId{201}, 5, 1)});
  EXPECT_THAT(hear(kLeftLink, {entry(kFar, 6, 1)}).lost, ElementsAre(OwnerId{201}));
  auto first = page({entry(kLeft, 9, 0, 11)});
  first.pages = 2;
  EXPECT_FALSE(routes.receive(kLeftLink, first, now).any()) << "another page follows";
  auto second = page({entry(OwnerId{202}, 1, 1)});
  second.page = 1;
  second.pages = 2;
  const auto changes = routes.receive(kLeftLink, second, now);
  EXPECT_THAT(changes.lost, ElementsAre(kFar));
  EXPECT_THAT(changes.found, ElementsAre(OwnerId{202}));
}

TEST_F(PeisRoutes, ALostRouteNeedsANewerSequenceOrAnotherStart) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 1)});
  routes.close(kLeftLink, now);
  EXPECT_FALSE(hear(kRightLink, {entry(kFar, 5, 1)}).any());
  EXPECT_FALSE(hear(kRightLink, {entry(kFar, 4, 1)}).any());
  EXPECT_THAT(hear(kRightLink, {entry(kFar, 6, 1)}).found, ElementsAre(kFar));
  routes.forget(kFar, now);
  EXPECT_FALSE(hear(kRightLink, {entry(kFar, 6, 1)}).any());
  EXPECT_THAT(hear(kRightLink, {entry(kFar, 0, 1, 8)}).found, ElementsAre(kFar));
}

TEST_F(PeisRoutes, AnotherStartIsFoundAndAnEndedOneIsNot) {
  open_both();
  hear(kLeftLink, {entry(kFar, 500, 1, 7)});
  over.insert(7);
  EXPECT_THAT(hear(kRightLink, {entry(kFar, 0, 3, 8)}).found, ElementsAre(kFar)) << "its sequence begins again";
  EXPECT_FALSE(hear(kLeftLink, {entry(kFar, 501, 1, 7)}).any());
  EXPECT_EQ(routes.find(kFar)->magic, 8u);
}

TEST_F(PeisRoutes, NoRouteIsAdvertisedToTheNeighbourItLeadsOver) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 1)});
  EXPECT_FALSE(advertises(kLeftLink, kFar));
  EXPECT_TRUE(advertises(kRightLink, kFar));
  EXPECT_TRUE(advertises(kRightLink, kLeft));
}

TEST_F(PeisRoutes, ALostRouteIsAdvertisedAsLostForFourSteps) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 1)});
  routes.forget(kFar, now);
  const auto hops = [&] {
    for (const auto& offered : routes.entries_for(kRightLink, now)) {
      if (offered.id == kFar) return int{offered.hops};
    }
    return -1;
  };
  EXPECT_EQ(hops(), 250);
  now += 10s;
  EXPECT_EQ(hops(), 251);
  now += 31s;
  routes.age(now);
  EXPECT_EQ(hops(), -1);
}

TEST_F(PeisRoutes, ARouteWithoutANewSequenceForAMinuteIsLost) {
  open_both();
  hear(kLeftLink, {entry(kFar, 5, 1)});
  for (int i = 0; i < 6; ++i) {
    now += 10s;
    hear(kLeftLink, {entry(kFar, 5, 1)});
    EXPECT_FALSE(routes.age(now).any());
  }
  now += 10s;
  EXPECT_THAT(routes.age(now).lost, ElementsAre(kFar));
}

TEST_F(PeisRoutes, WhatOthersSayOfUsOfNeighboursAndOfNoIdsDoesNotCount) {
  open_both();
  const auto changes = hear(kLeftLink, {entry(kMiddle, 99, 1), entry(kRight, 99, 1, 13), entry(OwnerId{0}, 1, 1),
                                        entry(OwnerId{0x80000000}, 1, 1)});
  EXPECT_FALSE(changes.any());
  EXPECT_EQ(routes.find(kRight)->via, kRight);
  EXPECT_EQ(routes.find(kRight)->sequence, 0u);
  EXPECT_FALSE(hear(LinkId{99}, {entry(kFar, 1, 1)}).any()) << "no such link";
}

TEST_F(PeisRoutes, TheClusterIsTheLowestIdThatCanBeReached) {
  EXPECT_EQ(routes.cluster(), kMiddle);
  open_both();
  EXPECT_EQ(routes.cluster(), kMiddle);
  hear(kLeftLink, {entry(OwnerId{3}, 5, 1)});
  EXPECT_EQ(routes.cluster(), OwnerId{3});
}

}  // namespace
}  // namespace rubicon::tuples::peis
