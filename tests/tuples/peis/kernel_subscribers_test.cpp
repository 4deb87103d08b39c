#include "tuples/peis/kernel_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

struct PeisKernelSubscribers : ::testing::Test {
  Result<KernelSubscribers::Entry*> add(std::string_view key, bool force = true) {
    Subscribe copy;
    copy.force_resend = force;
    copy.prototype.key = key;
    return subscribers.add(copy, now);
  }
  std::size_t removed(std::string_view key) {
    Unsubscribe out;
    out.key = key;
    return subscribers.remove(out).size();
  }

  SteadyTime now{1h};
  KernelSubscribers subscribers;
};

TEST_F(PeisKernelSubscribers, CountTheHandlesOfARoundAndThoseAfterIt) {
  ASSERT_TRUE(add("a", false));  // a handle that is older than our meeting
  now += 10s;
  ASSERT_TRUE(add("a"));  // and a new one
  EXPECT_EQ(removed("a"), 0u);
  EXPECT_EQ(removed("A"), 1u);
  EXPECT_EQ(removed("a"), 0u) << "there is none any more";
}

TEST_F(PeisKernelSubscribers, AHandleThatComesWithForceAndInTheRoundIsOne) {
  ASSERT_TRUE(add("a"));
  ASSERT_TRUE(add("a", false));
  EXPECT_EQ(removed("a"), 1u);
}

TEST_F(PeisKernelSubscribers, AreBounded) {
  for (std::size_t i = 0; i < KernelSubscribers::kMaxEntries; ++i) ASSERT_TRUE(add("k" + std::to_string(i)));
  EXPECT_EQ(add("more").error().code, ErrorCode::kBusy);
  EXPECT_TRUE(add("k7")) << "known";
  EXPECT_EQ(removed("k7"), 0u);
  EXPECT_EQ(removed("k8"), 1u);
  EXPECT_TRUE(add("more"));
}

TEST_F(PeisKernelSubscribers, HaveABoundedNumberOfSpellings) {
  auto& entry = **add("abcdefgh.*");
  std::size_t added = 0;
  for (unsigned bits = 1; bits < 40; ++bits) {
    std::string key = "abcdefgh.x";
    for (unsigned i = 0; i < 8; ++i) {
      if ((bits >> i & 1) != 0) key[i] = static_cast<char>(key[i] - 'a' + 'A');
    }
    if (subscribers.add_spelling(entry, key)) ++added;
  }
  EXPECT_EQ(added, KernelSubscribers::kMaxSpellings - 1);
  EXPECT_EQ(removed("abcdefgh.*"), KernelSubscribers::kMaxSpellings);
}

TEST_F(PeisKernelSubscribers, WantWhatTheirFiltersLetPass) {
  EXPECT_TRUE(subscribers.wants("x", "text/plain", "1", OwnerId{7})) << "the space matched it";
  Subscribe one;
  one.prototype.key = "x";
  one.prototype.data = "ON";
  one.prototype.creator = OwnerId{7};
  ASSERT_TRUE(subscribers.add(one, now));
  EXPECT_TRUE(subscribers.wants("x", "text/plain", "on", OwnerId{7}));
  EXPECT_FALSE(subscribers.wants("x", "text/plain", "off", OwnerId{7}));
  EXPECT_FALSE(subscribers.wants("x", "text/plain", "on", OwnerId{8}));
  ASSERT_TRUE(add("x"));
  EXPECT_TRUE(subscribers.wants("x", "text/plain", "off", OwnerId{8})) << "another one without a filter";
}

TEST_F(PeisKernelSubscribers, CompareWithABoundedAmountOfData) {
  Subscribe one;
  one.prototype.key = "x";
  const std::string longer(KernelSubscribers::kMaxData + 1, 'd');
  one.prototype.data = longer;
  EXPECT_EQ(subscribers.add(one, now).error().code, ErrorCode::kOutOfRange);
  std::size_t taken = 0;
  for (; taken < 2 * KernelSubscribers::kMaxDataOfAll / KernelSubscribers::kMaxData; ++taken) {
    auto data = std::to_string(taken);
    data.resize(KernelSubscribers::kMaxData, '.');
    one.prototype.data = data;
    if (!subscribers.add(one, now)) break;
  }
  EXPECT_EQ(taken, KernelSubscribers::kMaxDataOfAll / KernelSubscribers::kMaxData);
  std::string first = "0";
  first.resize(KernelSubscribers::kMaxData, '.');
  Unsubscribe end;
  end.key = "x";
  end.data = first;
  EXPECT_EQ(subscribers.remove(end).size(), 1u);
  one.prototype.data = first;
  EXPECT_TRUE(subscribers.add(one, now)) << "there is room again";
}

TEST_F(PeisKernelSubscribers, AFilterThatEndedFiltersNothing) {
  ASSERT_TRUE(add("y"));
  Subscribe one;
  one.prototype.key = "x";
  one.prototype.data = "on";
  ASSERT_TRUE(subscribers.add(one, now));
  EXPECT_FALSE(subscribers.wants("x", "text/plain", "off", OwnerId{7}));
  EXPECT_TRUE(subscribers.wants("Y", "text/plain", "off", OwnerId{7}));
  Unsubscribe end;
  end.key = "x";
  end.data = "ON";
  EXPECT_EQ(subscribers.remove(end).size(), 1u);
  EXPECT_TRUE(subscribers.wants("x", "text/plain", "off", OwnerId{7})) << "the space matched it";
}

struct PeisKernelCopies : ::testing::Test {
  KernelCopies::News take(std::string_view key, std::string_view data, std::uint32_t number, std::uint32_t appends) {
    NetworkTuple tuple;
    tuple.owner = tuple.creator = OwnerId{101};
    tuple.key = key;
    tuple.write_time = WallTime(1000s);
    tuple.user_time = tuple.expire_time = WallTime{};
    if (lifetime > Duration(0))
      tuple.expire_time = WallTime(1000s) + std::chrono::floor<std::chrono::seconds>(lifetime);
    tuple.encoding = Encoding::kAscii;
    tuple.media_type = "text/plain";
    tuple.data = data;
    tuple.sequence = number;
    tuple.appends = appends;
    return copies.take(tuple, now);
  }
  std::size_t append(std::string_view key, std::string_view difference, std::uint32_t number) {
    PushAppended news;
    news.tuple.owner = OwnerId{101};
    news.tuple.key = key;
    news.tuple.sequence = number;
    news.difference = difference;
    return copies.append(news).size();
  }

  SteadyTime now{1h};
  Duration lifetime{};
  KernelCopies copies;
};

TEST_F(PeisKernelCopies, SequencesRiseWithSetsAndAppendsFromAnyAppendNumber) {
  EXPECT_EQ(take("a", std::string_view("1\0", 2), 4, 538976288), KernelCopies::News::kNew);
  EXPECT_EQ(copies.find("A")->sequence, 5u);
  EXPECT_EQ(append("a", std::string_view(";2\0", 3), 4), 1u);
  EXPECT_EQ(copies.find("a")->data, std::string("1;2\0", 4));
  EXPECT_EQ(copies.find("a")->sequence, 6u);
  EXPECT_EQ(append("a", "late", 3), 0u) << "of an older value";
  EXPECT_EQ(take("a", std::string_view("3\0", 2), 5, 0), KernelCopies::News::kNew);
  EXPECT_EQ(copies.find("a")->sequence, 7u);
  EXPECT_EQ(take("a", "again", 5, 0), KernelCopies::News::kOld);
}

TEST_F(PeisKernelCopies, AnAppendByPatternIsForAllThatMatch) {
  EXPECT_EQ(take("ap.x", "1", 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("ap.y", "1", 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("other", "1", 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(append("ap.*", "2", 0), 2u);
}

TEST_F(PeisKernelCopies, ARoundRemovesWhatDidNotComeAgain) {
  EXPECT_EQ(take("a", "1", 9, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("b", "1", 9, 0), KernelCopies::News::kNew);
  copies.begin_round();
  EXPECT_EQ(take("a", "2", 0, 0), KernelCopies::News::kNew) << "whatever its number";
  copies.end_round("*");
  EXPECT_EQ(copies.size(), 1u);
  EXPECT_EQ(copies.find("b"), nullptr);
  EXPECT_GT(copies.find("a")->sequence, 10u);
}

TEST_F(PeisKernelCopies, EndWithTheLifetimeOfTheirTuples) {
  lifetime = 2s;
  EXPECT_EQ(take("a", "1", 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("b", "1", 0, 0), KernelCopies::News::kNew);
  lifetime = Duration(0);
  EXPECT_EQ(take("for.ever", "1", 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("b", "2", 1, 0), KernelCopies::News::kNew) << "it lasts now";
  EXPECT_EQ(copies.next_expiry(), now + 2s);
  copies.expire(now + 1s);
  EXPECT_EQ(copies.size(), 3u);
  copies.expire(now + 2s);
  EXPECT_EQ(copies.find("a"), nullptr);
  EXPECT_EQ(copies.size(), 2u);
  EXPECT_EQ(copies.next_expiry(), SteadyTime::max());
}

TEST_F(PeisKernelCopies, AreBoundedInBytes) {
  const std::string big(KernelCopies::kMaxBytes / 2, 'x');
  EXPECT_EQ(take("a", big, 0, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("b", big, 0, 0), KernelCopies::News::kNoRoom);
  EXPECT_EQ(append("a", big, 0), 0u);
  EXPECT_EQ(copies.refused_appends(), 1u);
  EXPECT_EQ(take("a", "1", 1, 0), KernelCopies::News::kNew);
  EXPECT_EQ(take("b", big, 0, 0), KernelCopies::News::kNew);
}

}  // namespace
}  // namespace rubicon::tuples::peis
