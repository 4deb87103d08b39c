#include "tuples/dds/kept_sets.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::dds {
namespace {

constexpr OwnerId kDesk{70'000}, kRoof{70'001};

Reply applied(OwnerId to, std::uint64_t request) {
  Reply reply;
  reply.to = to;
  reply.request = request;
  reply.sequence = 10 * request;
  return reply;
}

void exchange(RecentReplies& replies, const Reply& reply) {
  replies.asked(reply.to, reply.request);
  replies.answered(reply);
}

bool is_lost(const std::optional<Reply>& reply) {
  return reply && reply->verdict == Verdict::kRefused && reply->code == ErrorCode::kUnreachable;
}

TEST(RecentReplies, AreRepeated) {
  RecentReplies replies;
  exchange(replies, applied(kDesk, 1));
  const auto again = replies.repeat(kDesk, 1);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->to, kDesk);
  EXPECT_EQ(again->request, 1U);
  EXPECT_EQ(again->verdict, Verdict::kApplied);
  EXPECT_EQ(again->sequence, 10U);
  EXPECT_TRUE(again->text.empty());
  EXPECT_TRUE(is_lost(replies.repeat(kRoof, 1))) << "of another component";
}

TEST(RecentReplies, WithALongTextAreRepeatedWithAnother) {
  RecentReplies replies;
  auto refusal = applied(kDesk, 1);
  refusal.verdict = Verdict::kRefused;
  refusal.code = ErrorCode::kOutOfRange;
  refusal.text.assign(5000, 'x');
  exchange(replies, refusal);
  const auto again = replies.repeat(kDesk, 1);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->verdict, Verdict::kRefused);
  EXPECT_EQ(again->code, ErrorCode::kOutOfRange);
  EXPECT_FALSE(again->text.empty());
  EXPECT_LT(again->text.size(), 100U);
}

TEST(RecentReplies, TheOldestOfAComponentAreLostAndThatIsSaid) {
  RecentReplies replies;
  replies.asked(kDesk, 1);
  for (std::uint64_t i = 2; i < RecentReplies::kMostOfOne + 3; ++i) exchange(replies, applied(kDesk, i));
  EXPECT_FALSE(replies.repeat(kDesk, 1)) << "still open: its reply will come";
  EXPECT_TRUE(is_lost(replies.repeat(kDesk, 2)));
  EXPECT_EQ(replies.repeat(kDesk, 3)->verdict, Verdict::kApplied);
}

TEST(RecentReplies, OfAllComponentsAreBounded) {
  RecentReplies replies(64 * 1024);
  exchange(replies, applied(kDesk, 1));
  for (std::uint32_t i = 0; i < 1000; ++i) exchange(replies, applied(OwnerId{80'000 + i}, 1));
  EXPECT_TRUE(is_lost(replies.repeat(kDesk, 1)));
  EXPECT_TRUE(is_lost(replies.repeat(OwnerId{80'000}, 1)));
  EXPECT_EQ(replies.repeat(OwnerId{80'999}, 1)->verdict, Verdict::kApplied);
}

TEST(RecentReplies, AreDroppedButWhatIsOpenStays) {
  RecentReplies replies;
  replies.asked(kDesk, 1);
  exchange(replies, applied(kDesk, 2));
  replies.drop(kDesk);
  EXPECT_FALSE(replies.repeat(kDesk, 1));
  EXPECT_TRUE(is_lost(replies.repeat(kDesk, 2)));
  replies.answered(applied(kDesk, 1));
  EXPECT_EQ(replies.repeat(kDesk, 1)->verdict, Verdict::kApplied);
  replies.forget(kDesk);
  EXPECT_TRUE(is_lost(replies.repeat(kDesk, 1)));
  replies.answered(applied(kDesk, 1));
  EXPECT_TRUE(is_lost(replies.repeat(kDesk, 1))) << "of a component that is gone";
}

}  // namespace
}  // namespace rubicon::tuples::dds
