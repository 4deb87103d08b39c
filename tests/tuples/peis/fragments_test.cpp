#include "tuples/peis/fragments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/virtual_scheduler.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

constexpr OwnerId kLeft{200}, kRight{300};

Bytes message(std::size_t size, std::uint8_t seed = 1) {
  Bytes bytes(size);
  std::mt19937 random(seed);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

struct Sent {
  PackageHeader header;
  Bytes body;
};

/// The packages of a long message; ack ids begin at `ack_id`.
std::vector<Sent> packages_of(ByteView bytes, OwnerId source, std::uint16_t id, std::uint32_t ack_id = 1000) {
  const auto count = count_fragments(bytes.size()).value();
  std::vector<Sent> all;
  for (std::uint16_t i = 0; i < count; ++i) {
    Sent one;
    one.header.source = source;
    one.header.port = Port::kPush;
    one.header.ack_id = ack_id + i;
    one.header.fragments = count;
    one.header.message = id;
    one.header.fragment = i;
    const auto body = fragment_of(bytes, i);
    one.body.assign(body.begin(), body.end());
    all.push_back(std::move(one));
  }
  return all;
}

struct Bench {
  explicit Bench(const Fragments::Limits& limits = {}) : fragments(time, limits) {}

  /// The message that the package completed; empty = none yet.
  Bytes add(const Sent& sent) {
    const auto result = fragments.add(sent.header, sent.body);
    EXPECT_TRUE(result) << result.error().text;
    return result ? result->value_or(Bytes()) : Bytes();
  }
  std::vector<Bytes> add_all(const std::vector<Sent>& all) {
    std::vector<Bytes> messages;
    for (const auto& sent : all) {
      if (auto whole = add(sent); !whole.empty()) messages.push_back(std::move(whole));
    }
    return messages;
  }
  ErrorCode refused(const Sent& sent) { return fragments.add(sent.header, sent.body).error().code; }

  VirtualScheduler time;
  Fragments fragments;
};

TEST(PeisFragments, AMessageIsCutAsTheReferenceShows) {
  EXPECT_EQ(count_fragments(0).value(), 1);
  EXPECT_EQ(count_fragments(1024).value(), 1);
  EXPECT_EQ(count_fragments(1025).value(), 2);
  EXPECT_EQ(count_fragments(3243).value(), 4);
  EXPECT_EQ(count_fragments(kMaxMessage).value(), kMaxFragments);
  EXPECT_EQ(count_fragments(kMaxMessage + 1).error(),
            (Error{ErrorCode::kOutOfRange, "message of 33553409 bytes, expected at most 33553408"}));
  std::vector<std::size_t> sizes;
  for (const auto& sent : packages_of(message(3243), kLeft, 1)) sizes.push_back(sent.body.size());
  EXPECT_EQ(sizes, (std::vector<std::size_t>{1024, 1024, 1024, 171}));
}

TEST(PeisFragments, AMessageIsWholeInAnyOrderOfItsParts) {
  const auto whole = message(9000);
  auto parts = packages_of(whole, kLeft, 1);
  std::mt19937 random(5);
  for (int round = 0; round < 20; ++round) {
    Bench bench;
    std::shuffle(parts.begin(), parts.end(), random);
    EXPECT_EQ(bench.add_all(parts), std::vector<Bytes>{whole});
    EXPECT_EQ(bench.fragments.incomplete(), 0U);
    EXPECT_EQ(bench.fragments.bytes(), 0U);
  }
}

TEST(PeisFragments, TwoSourcesMayUseOneMessageId) {
  Bench bench;
  const auto left = message(3000, 1), right = message(3000, 2);
  const auto of_left = packages_of(left, kLeft, 7), of_right = packages_of(right, kRight, 7);
  std::vector<Sent> mixed;
  for (std::size_t i = 0; i < of_left.size(); ++i) {
    mixed.push_back(of_left[i]);
    mixed.push_back(of_right[i]);
  }
  EXPECT_EQ(bench.add_all(mixed), (std::vector<Bytes>{left, right}));
}

TEST(PeisFragments, PartsOfTwoPortsAreNotOneMessage) {
  Bench bench;
  const auto older = message(3000, 1), newer = message(3000, 2);
  auto of_older = packages_of(older, kLeft, 7, 1000), of_newer = packages_of(newer, kLeft, 7, 2000);
  for (auto& part : of_newer) part.header.port = Port::kSetRemote;
  bench.add(of_older[0]);
  std::vector<Sent> rest(of_newer.begin() + 1, of_newer.end());
  EXPECT_EQ(bench.add_all(rest), std::vector<Bytes>{}) << "the first part is that of another message";
  EXPECT_EQ(bench.add_all({of_newer[0]}), std::vector<Bytes>{newer});
}

TEST(PeisFragments, APartThatComesAgainIsIgnored) {
  Bench bench;
  const auto whole = message(4000);
  const auto parts = packages_of(whole, kLeft, 1);
  auto twice = parts;
  twice.insert(twice.begin(), parts.begin(), parts.end() - 1);
  EXPECT_EQ(bench.add_all(twice), std::vector<Bytes>{whole});
  EXPECT_EQ(bench.fragments.counters().duplicates, parts.size() - 1);
}

TEST(PeisFragments, AWholeMessageThatComesAgainIsNotDeliveredAgain) {
  Bench bench;
  const auto parts = packages_of(message(4000), kLeft, 1);
  EXPECT_EQ(bench.add_all(parts).size(), 1U);
  bench.time.run_for(11600ms);  // the last resend of a source
  EXPECT_TRUE(bench.add_all(parts).empty());
  EXPECT_EQ(bench.fragments.incomplete(), 0U);
}

TEST(PeisFragments, AMessageIdThatIsUsedAgainIsAnotherMessage) {
  Bench bench;
  const auto first = message(4000, 1), second = message(4000, 2);
  EXPECT_EQ(bench.add_all(packages_of(first, kLeft, 1, 1000)), std::vector<Bytes>{first});
  EXPECT_EQ(bench.add_all(packages_of(second, kLeft, 1, 2000)), std::vector<Bytes>{second});
}

TEST(PeisFragments, PartsOfTwoMessagesAreNeverMixed) {
  Bench bench;
  const auto first = message(4000, 1), second = message(4000, 2), third = message(5000, 3);
  auto incomplete = packages_of(first, kLeft, 1, 1000);
  incomplete.pop_back();
  EXPECT_TRUE(bench.add_all(incomplete).empty());
  EXPECT_EQ(bench.add_all(packages_of(second, kLeft, 1, 2000)), std::vector<Bytes>{second}) << "the same parts";
  EXPECT_TRUE(bench.add_all({incomplete.begin(), incomplete.begin() + 1}).empty());
  EXPECT_EQ(bench.add_all(packages_of(third, kLeft, 1, 3000)), std::vector<Bytes>{third}) << "another count";
  EXPECT_EQ(bench.fragments.counters().replaced, 2U);
  EXPECT_EQ(bench.fragments.bytes(), 0U);
}

TEST(PeisFragments, AnIncompleteMessageIsForgottenTenSecondsAfterItsLastPart) {
  Bench bench;
  auto parts = packages_of(message(4000), kLeft, 1);
  const auto last = parts.back();
  parts.pop_back();
  for (const auto& part : parts) {
    bench.add(part);
    bench.time.run_for(9900ms);
  }
  EXPECT_EQ(bench.fragments.incomplete(), 1U);
  bench.time.run_for(100ms);
  EXPECT_EQ(bench.fragments.incomplete(), 0U);
  EXPECT_EQ(bench.fragments.bytes(), 0U);
  EXPECT_EQ(bench.fragments.counters().expired, 1U);
  EXPECT_TRUE(bench.add(last).empty());
}

TEST(PeisFragments, EachMessageHasATimeOfItsOwn) {
  Bench bench;
  for (std::uint16_t id = 1; id <= 5; ++id) {
    bench.add(packages_of(message(4000), kLeft, id).front());
    bench.time.run_for(1s);
  }
  for (std::size_t left = 5; left > 0; --left) {
    bench.time.run_for(left == 5 ? 5s : 1s);
    EXPECT_EQ(bench.fragments.incomplete(), left - 1);
  }
}

TEST(PeisFragments, LostPartsAreMadeGoodByResends) {
  Bench bench;
  const auto whole = message(60000);
  const auto parts = packages_of(whole, kLeft, 1);
  std::mt19937 random(3);
  std::vector<Bytes> delivered;
  for (int resend = 0; resend <= kResends; ++resend) {
    for (const auto& part : parts) {
      if (random() % 2 == 0) continue;
      if (auto done = bench.add(part); !done.empty()) delivered.push_back(std::move(done));
    }
    bench.time.run_for((resend + 1) * kResendStep);
  }
  EXPECT_EQ(delivered, std::vector<Bytes>{whole});
}

TEST(PeisFragments, AFloodOfOneSourceLeavesRoomForOthers) {
  Bench bench;
  std::uint16_t taken = 0;
  for (std::uint16_t id = 1; id <= kMaxMessageId; ++id) {
    const auto part = packages_of(message(2000), kLeft, id, id * 10U).front();
    if (bench.fragments.add(part.header, part.body)) ++taken;
  }
  EXPECT_EQ(taken, Fragments::Limits{}.messages_of_source);
  const auto whole = message(3000);
  EXPECT_EQ(bench.add_all(packages_of(whole, kRight, 1)), std::vector<Bytes>{whole});
  bench.time.run_for(10s);
  EXPECT_EQ(bench.fragments.incomplete(), 0U);
  EXPECT_EQ(bench.add_all(packages_of(whole, kLeft, 1)), std::vector<Bytes>{whole});
}

TEST(PeisFragments, AFloodOfManySourcesIsBounded) {
  Bench bench;
  const auto body = message(1024);
  PackageHeader header;
  header.fragments = kMaxFragments;
  for (std::uint32_t i = 0; i < 200000; ++i) {
    header.source = OwnerId{i % 5000 + 1};
    header.message = static_cast<std::uint16_t>(i % 40 + 1);
    header.fragment = static_cast<std::uint16_t>(i % kMaxFragments);
    header.ack_id = i;
    (void)bench.fragments.add(header, body);
  }
  EXPECT_LE(bench.fragments.incomplete(), Fragments::Limits{}.messages);
  EXPECT_LE(bench.fragments.bytes(), Fragments::Limits{}.bytes);
  EXPECT_GT(bench.fragments.counters().refused, 0U);
}

TEST(PeisFragments, WhatIsBeyondTheBytesIsRefusedUntilThereIsRoom) {
  Fragments::Limits limits;
  limits.bytes = limits.bytes_of_source = 4 * (kMaxBody + Fragments::kOverhead);
  Bench bench(limits);
  const auto long_one = packages_of(message(5 * 1024), kLeft, 1);
  for (std::size_t i = 0; i < 4; ++i) bench.add(long_one[i]);
  EXPECT_EQ(bench.refused(long_one[4]), ErrorCode::kBusy);
  EXPECT_EQ(bench.refused(packages_of(message(2000), kRight, 1).front()), ErrorCode::kBusy);
  bench.time.run_for(10s);
  EXPECT_TRUE(bench.add(packages_of(message(2000), kRight, 1).front()).empty());
}

TEST(PeisFragments, TheLongestMessageFits) {
  Bench bench;
  const auto whole = message(kMaxMessage);
  const auto messages = bench.add_all(packages_of(whole, kLeft, 1));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0] == whole);
}

TEST(PeisFragments, NumbersThatContradictThemselvesAreInvalid) {
  Bench bench;
  auto part = packages_of(message(2000), kLeft, 1).front();
  part.header.fragment = 2;
  const auto result = bench.fragments.add(part.header, part.body);
  EXPECT_EQ(result.error(),
            (Error{ErrorCode::kInvalid, "fragment 2 of 2 from 200, expected an index below a count of 1 to 32767"}));
  part.header.fragments = 0;
  EXPECT_EQ(bench.refused(part), ErrorCode::kInvalid);
  part.header.fragments = kMaxFragments + 1;
  EXPECT_EQ(bench.refused(part), ErrorCode::kInvalid);
  EXPECT_EQ(bench.fragments.counters().invalid, 3U);
  EXPECT_EQ(bench.fragments.incomplete(), 0U);
}

TEST(PeisFragments, AMessageOfOneFragmentIsWhole) {
  Bench bench;
  auto part = packages_of(message(100), kLeft, 1).front();
  EXPECT_EQ(part.header.fragments, 1);
  EXPECT_EQ(bench.add(part), message(100));
}

TEST(PeisFragments, TheMessagesOfASourceThatEndedAreForgotten) {
  Bench bench;
  const auto whole = message(3000);
  const auto of_left = packages_of(whole, kLeft, 1), of_right = packages_of(whole, kRight, 1);
  EXPECT_EQ(bench.add_all(packages_of(whole, kLeft, 2)).size(), 1U);
  bench.add(of_left[0]);
  bench.add(of_right[0]);
  bench.fragments.forget(kLeft);
  EXPECT_EQ(bench.fragments.incomplete(), 1U);
  EXPECT_EQ(bench.add_all(packages_of(whole, kLeft, 2)).size(), 1U) << "the same ack ids after a restart";
  EXPECT_EQ(bench.add_all({of_right.begin() + 1, of_right.end()}).size(), 1U);
}

TEST(PeisFragments, WhatIsRememberedOfCompleteMessagesIsBounded) {
  Fragments::Limits limits;
  limits.remembered = 10;
  Bench bench(limits);
  const auto old = packages_of(message(4000), kLeft, 1);
  EXPECT_EQ(bench.add_all(old).size(), 1U);
  for (std::uint16_t id = 2; id <= 4; ++id) EXPECT_EQ(bench.add_all(packages_of(message(4000), kLeft, id)).size(), 1U);
  EXPECT_EQ(bench.add_all(old).size(), 1U) << "forgotten: the duplicate table of the node must know it";
}

}  // namespace
}  // namespace rubicon::tuples::peis
