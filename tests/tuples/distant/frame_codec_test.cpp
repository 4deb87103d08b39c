#include "tuples/distant/frame_codec.h"

#include <gmock/gmock.h>

namespace rubicon::tuples::distant {
namespace {

constexpr OwnerId kIsland{6541}, kSender{70001};

struct Entries final : FrameReader {
  void on_changes(std::span<const Change> some) override {
    for (const auto& change : some) {
      changes.push_back(change);
    }
  }
  void on_set(RemoteSet&& set) override { sets.push_back(std::move(set)); }
  void on_reply(Reply&& reply) override { replies.push_back(std::move(reply)); }
  void on_identity_check(const IdentityCheck& check) override { checks.push_back(check); }
  void on_times(const FrameTimes& some) override { times.push_back(some); }

  std::vector<Change> changes;
  std::vector<RemoteSet> sets;
  std::vector<Reply> replies;
  std::vector<IdentityCheck> checks;
  std::vector<FrameTimes> times;
};

TupleSet lamp() {
  TupleSet change;
  change.tuple = {kIsland,
                  "proxy.hall.lamp",
                  std::string_view("on\0", 3),
                  "text/plain",
                  kSender,
                  300,
                  WallTime(std::chrono::microseconds(1'800'000'000'000'000)),
                  WallTime(std::chrono::microseconds(-5)),
                  WallTime{}};
  return change;
}

RemoteSet append_request() {
  RemoteSet set;
  set.from = kSender;
  set.owner = kIsland;
  set.request = 7;
  set.key = "proxy.hall.lamp.command";
  set.value = "off";
  set.lifetime = std::chrono::seconds(3);
  set.time_to_live = std::chrono::milliseconds(5001);
  set.time_to_live_given = true;
  set.append = true;
  set.expected_sequence = 0;
  return set;
}

TEST(Frame, BringsWhoseWishASetIs) {
  FrameWriter frame;
  auto set = append_request();
  set.asker = "user:ann@hall";
  frame.add(set);
  set.asker = std::string(kMaxAsker + 1, 'a');
  frame.add(set);
  Entries read;
  ASSERT_TRUE(read_frame(frame.view(), kIsland, kSender, read));
  ASSERT_EQ(read.sets.size(), 2U);
  EXPECT_EQ(read.sets[0].asker, "user:ann@hall");
  EXPECT_EQ(read.sets[1].asker, "") << "too long: nobody is named";
}

TEST(Frame, BringsEveryEntryInItsOrderAsItWas) {
  FrameWriter frame;
  frame.add(Change(lamp()));
  frame.add(TupleGone{EventKind::kExpired, lamp().tuple.key, 301});
  frame.add(append_request());
  frame.add(Reply{kSender, 8, Verdict::kRefused, ErrorCode::kBusy, "later", 9});
  Entries read;
  ASSERT_TRUE(read_frame(frame.view(), kIsland, kSender, read));
  ASSERT_EQ(read.changes.size(), 2U);
  const auto& tuple = std::get<TupleSet>(read.changes[0]).tuple;
  EXPECT_EQ(tuple.owner, kIsland);
  EXPECT_EQ(tuple.creator, kSender);
  EXPECT_EQ(tuple.sequence, 300U);
  EXPECT_EQ(tuple.value, std::string_view("on\0", 3));
  EXPECT_EQ(tuple.write_time, lamp().tuple.write_time);
  EXPECT_EQ(tuple.user_time, lamp().tuple.user_time);
  const auto& gone = std::get<TupleGone>(read.changes[1]);
  EXPECT_EQ(gone.how, EventKind::kExpired);
  EXPECT_EQ(gone.key, "proxy.hall.lamp");
  EXPECT_EQ(gone.sequence, 301U);
  ASSERT_EQ(read.sets.size(), 1U);
  const auto& set = read.sets[0];
  EXPECT_EQ(set.from, kIsland);
  EXPECT_EQ(set.owner, kSender);
  EXPECT_EQ(set.time_to_live, append_request().time_to_live);
  EXPECT_TRUE(set.append && set.time_to_live_given);
  EXPECT_EQ(set.expected_sequence, 0U);
  ASSERT_EQ(read.replies.size(), 1U);
  EXPECT_EQ(read.replies[0].code, ErrorCode::kBusy);
  EXPECT_EQ(read.replies[0].text, "later");
}

TEST(Frame, CarriesControlMessagesAsSetsWithAnEmptyKey) {
  FrameWriter frame;
  frame.add(SnapshotEnd{5});
  frame.add(Restart{});
  frame.add(Restart{WallTime(std::chrono::microseconds(7))});
  EXPECT_EQ(base::to_hex(frame.view()),
            "000005000000000000"
            "000000000000000000"
            "0000000000000e0000");
  Entries read;
  ASSERT_TRUE(read_frame(frame.view(), kIsland, kSender, read));
  ASSERT_EQ(read.changes.size(), 3U);
  EXPECT_EQ(std::get<SnapshotEnd>(read.changes[0]).subscription, 5U);
  EXPECT_EQ(std::get<Restart>(read.changes[1]).since, WallTime{}) << "as earlier releases send it";
  EXPECT_EQ(std::get<Restart>(read.changes[2]).since, WallTime(std::chrono::microseconds(7)));
}

TEST(Frame, BringsTimesInMicroseconds) {
  FrameWriter frame;
  frame.add(FrameTimes{std::chrono::nanoseconds(300'999), {}, {}, true});
  frame.add(
      FrameTimes{std::chrono::microseconds(7), std::chrono::microseconds(0), std::chrono::microseconds(9), false});
  EXPECT_EQ(base::to_hex(frame.view()), "0702ac020701070009");
  Entries read;
  ASSERT_TRUE(read_frame(frame.view(), kIsland, kSender, read));
  ASSERT_EQ(read.times.size(), 2U);
  EXPECT_EQ(read.times[0].sent, std::chrono::microseconds(300));
  EXPECT_TRUE(read.times[0].asks);
  EXPECT_FALSE(read.times[0].echo);
  EXPECT_EQ(read.times[1].echo, Duration(0));
  EXPECT_EQ(read.times[1].held, std::chrono::microseconds(9));
}

TEST(Frame, OfAHostThatRunsForACenturyIsInvalid) {
  FrameWriter frame;
  frame.add(FrameTimes{std::chrono::years(100), {}, {}, false});
  Entries read;
  EXPECT_FALSE(read_frame(frame.view(), kIsland, kSender, read));
  EXPECT_TRUE(read.times.empty());
}

TEST(Frame, CutAnywhereTellsWhatIsWholeAndWhereItEnds) {
  FrameWriter frame;
  frame.add(Change(lamp()));
  const auto whole = frame.size();
  frame.add(append_request());
  for (std::size_t size = 0; size < frame.size(); ++size) {
    Entries read;
    const auto done = read_frame(frame.view().first(size), kIsland, kSender, read);
    EXPECT_EQ(done.has_value(), size == 0 || size == whole) << size;
    EXPECT_EQ(read.changes.size(), size >= whole ? 1U : 0U) << size;
    EXPECT_TRUE(read.sets.empty());
    if (done) continue;
    EXPECT_THAT(done.error().text, testing::HasSubstr(size < whole ? "byte 0" : "byte"));
  }
}

TEST(Frame, RefusesWhatNobodyWrites) {
  Entries read;
  for (const auto* hex : {"05", "07", "ff", "0401ff0000", "04010a00", "00ffffffffffffffffff7f"}) {
    EXPECT_FALSE(read_frame(*base::from_hex(hex), kIsland, kSender, read)) << hex;
  }
  EXPECT_TRUE(read.changes.empty() && read.sets.empty() && read.replies.empty());
}

TEST(Interest, BringsASubscriptionAsItWas) {
  SubscriptionSpec spec{
      77, {kIsland, "proxy.*.status"}, {std::chrono::milliseconds(250), std::chrono::seconds(60), 0.5, true}};
  FrameWriter content;
  content.add(spec);
  const auto read = read_subscription(content.view());
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->id, spec.id);
  EXPECT_EQ(read->pattern, spec.pattern);
  EXPECT_EQ(read->flow, spec.flow);
  for (std::size_t size = 0; size < content.size(); ++size) EXPECT_FALSE(read_subscription(content.view().first(size)));
}

TEST(Frame, CarriesTheQuestionsOfTwoWithOneId) {
  FrameWriter frame;
  frame.add(IdentityCheck{false, 300});
  frame.add(IdentityCheck{true, 0xffffffffffffffff});
  EXPECT_EQ(base::to_hex(frame.view()), "05ac0206ffffffffffffffffff01");
  Entries entries;
  ASSERT_TRUE(read_frame(frame.view(), kSender, kSender, entries));
  ASSERT_EQ(entries.checks.size(), 2U);
  EXPECT_FALSE(entries.checks[0].is_answer);
  EXPECT_EQ(entries.checks[0].number, 300U);
  EXPECT_TRUE(entries.checks[1].is_answer);
  EXPECT_EQ(entries.checks[1].number, 0xffffffffffffffff);
}

}  // namespace
}  // namespace rubicon::tuples::distant
