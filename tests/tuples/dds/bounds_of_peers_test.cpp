#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/dds/early.h"
#include "tuples/dds/reader_stores.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

Participant participant(std::uint8_t number) {
  Participant who{};
  who[0] = number;
  return who;
}
const Participant kOne = participant(1), kOther = participant(2);
constexpr OwnerId kRobot{70000};

TEST(EarlyFrames, CountWhatTheyTakeBesideTheirContent) {
  EarlyFrames held;
  int taken = 0;
  while (held.add({kRobot, 5, kOne}, {}, SteadyTime{})) ASSERT_LT(++taken, 20'000);
  EXPECT_GT(taken, 1'000);
  EXPECT_LE(held.bytes(), EarlyFrames::kMaxOfOne);
  EXPECT_TRUE(held.add({kRobot, 5, kOther}, {}, SteadyTime{})) << "a flooder leaves room for others";
  for (std::uint8_t more = 3; more < 40; ++more) {
    for (int i = 0; i < 1'000; ++i) held.add({kRobot, 5, participant(more)}, Bytes(1'000), SteadyTime{});
  }
  EXPECT_LE(held.bytes(), EarlyFrames::kMaxOfAll);
}

TEST(EarlyFrames, AreGivenInTheirOrderOrDroppedWithTheirTime) {
  EarlyFrames held;
  const Bytes first{1}, second{2}, late{3};
  held.add({kRobot, 5, kOne}, first, SteadyTime(1s));
  held.add({kRobot, 6, kOne}, late, SteadyTime(1s));
  held.add({kRobot, 5, kOne}, second, SteadyTime(2s));
  EXPECT_THAT(held.take({kRobot, 5, kOne}), ElementsAre(first, second));
  held.drop_until(SteadyTime(1s));
  EXPECT_TRUE(held.empty());
  EXPECT_EQ(held.bytes(), 0U);
}

TEST(Interests, AreBoundedInBytesPerParticipantAndInAll) {
  Participants participants;
  Interests interests(participants);
  const SubscriptionSpec long_one{1, {std::nullopt, std::string(255, 'k')}, {}};
  const auto fill = [&](const Participant& who, std::uint32_t id) {
    std::uint32_t slot = 0;
    while (slot < 20'000 && interests.put({OwnerId(id + slot / 9'000), 1, slot}, who, long_one)) ++slot;
    return slot;
  };
  const auto first = fill(kOne, 70'000);
  EXPECT_LT(first * sizeof(SubscriptionSpec), Participants::kMaxInterestBytes);
  EXPECT_GT(first, 5'000U) << "more than anybody needs";
  std::size_t all = first;
  for (std::uint8_t who = 2; who < 60; ++who) all += fill(participant(who), 70'000 + 10U * who);
  EXPECT_LE(all * 255, Participants::kMaxInterestBytesOfAll);
  for (std::uint8_t who = 1; who < 60; ++who) interests.erase_all(participant(who));
  EXPECT_EQ(fill(kOne, 70'000), first) << "what ended makes room";
}

TEST(Interests, OfOneSlotBelongToTheirParticipants) {
  Participants participants;
  Interests interests(participants);
  const SubscriptionSpec spec{1, {std::nullopt, "a"}, {}}, other{2, {std::nullopt, "b"}, {}};
  const InterestKey slot{kRobot, 1, 0};
  ASSERT_TRUE(interests.put(slot, kOne, spec));
  ASSERT_TRUE(interests.put(slot, kOther, other));
  ASSERT_EQ(interests.of(kRobot, 1, kOne).size(), 1U);
  EXPECT_EQ(interests.of(kRobot, 1, kOne).front().id, 1U);
  EXPECT_EQ(interests.of(kRobot, 1, kOther).front().id, 2U);
  EXPECT_EQ(interests.participants(), (std::set{kOne, kOther}));
  interests.erase_all(kOne);
  EXPECT_TRUE(interests.of(kRobot, 1, kOne).empty());
  EXPECT_NE(interests.find(slot, kOther), nullptr);
}

TEST(Participants, WithTooManyComponentsAreIgnoredUntilTheyGo) {
  Participants participants;
  for (std::uint32_t i = 0; i < Participants::kMaxComponents; ++i)
    EXPECT_TRUE(participants.add(kOne, {OwnerId(i + 1), 1}));
  EXPECT_TRUE(participants.add(kOne, {OwnerId(1), 1})) << "again";
  EXPECT_FALSE(participants.add(kOne, {OwnerId(99), 1}));
  EXPECT_TRUE(participants.add(kOther, {OwnerId(99), 1}));
  EXPECT_EQ(participants.largest(), kOne);
  EXPECT_EQ(participants.ban(kOne).size(), Participants::kMaxComponents);
  EXPECT_TRUE(participants.is_banned(kOne));
  EXPECT_EQ(participants.largest(), std::nullopt) << "no component has more than one here";
  participants.keep_only({kOne, kOther});
  EXPECT_TRUE(participants.is_banned(kOne));
  participants.keep_only({kOther});
  EXPECT_FALSE(participants.is_banned(kOne));
}

}  // namespace
}  // namespace rubicon::tuples::dds
