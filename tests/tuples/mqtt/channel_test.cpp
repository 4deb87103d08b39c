#include "tuples/mqtt/channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/virtual_scheduler.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAreArray;
using testing::IsEmpty;

/// One end of a channel, whose frames pass a broker that drops what the test wants.
struct End {
  End(base::VirtualScheduler& time, std::uint32_t self, std::uint32_t peer, Duration its_clock)
      : time_(time), clock(its_clock), ends{OwnerId(self), OwnerId(peer), 1, 1} {}

  void open(std::uint64_t stream) {
    Channel::Callbacks calls;
    calls.send = [this](const FrameHead& head, ByteView entries) {
      if (busy) return Channel::Sent::kLater;
      ++frames;
      largest = std::max(largest, entries.size());
      if (!other || drops(head)) return Channel::Sent::kYes;
      const auto bytes = frame_of(head, entries);
      if (delay > Duration(0)) {
        on_their_way.push_back(time_.at(time_.now() + delay, [to = other, bytes] { to->take(bytes); }));
        return Channel::Sent::kYes;
      }
      time_.post([to = other, bytes] { to->take(bytes); });
      return Channel::Sent::kYes;
    };
    calls.too_large = [](ByteView) {};
    calls.may_swallow = [](std::size_t) { return false; };
    calls.received = [this](ByteView entries) { read(entries); };
    calls.met_again = [this] { ++met_again; };
    calls.credit = [this] { return credit; };
    calls.since_boot = [this] { return time_.now().time_since_epoch() + clock; };
    channel = std::make_unique<Channel>(time_, ends, stream, std::move(calls));
  }
  void take(const Bytes& bytes) {
    ByteView entries;
    const auto head = read_head(bytes, entries);
    if (head && channel) channel->arrived(*head, entries);
  }
  void read(ByteView entries) {
    struct Reader final : distant::FrameReader {
      explicit Reader(End& end) : end(end) {}
      void on_set(RemoteSet&& set) override { end.got.push_back(set.request); }
      void on_reply(Reply&& reply) override { end.got.push_back(reply.request); }
      void on_times(const distant::FrameTimes& times) override {
        end.channel->ages().arrived(times, end.time_.now().time_since_epoch() + end.clock);
      }
      End& end;
    } reader(*this);
    EXPECT_TRUE(distant::read_frame(entries, ends.peer, ends.self, reader));
  }
  void say(std::uint64_t number, std::size_t bytes = 10) {
    distant::FrameWriter entry;
    entry.add(Reply{ends.peer, number, Verdict::kApplied, ErrorCode::kIo, std::string(bytes, 'x'), 0});
    channel->add(entry.take());
    channel->flush();
  }

  base::VirtualScheduler& time_;
  Duration clock, delay{};
  Channel::Ends ends;
  End* other = nullptr;
  std::unique_ptr<Channel> channel;
  std::function<bool(const FrameHead& head)> drops = [](const FrameHead&) { return false; };
  bool busy = false;
  std::uint32_t credit = 64;
  int met_again = 0;
  std::size_t frames = 0, largest = 0;
  std::vector<std::uint64_t> got;
  std::vector<Timer> on_their_way;
};

struct Channels : testing::Test {
  Channels() {
    a.other = &b;
    b.other = &a;
    a.open(1);
    b.open(1);
  }
  static std::vector<std::uint64_t> up_to(std::uint64_t count) {
    std::vector<std::uint64_t> all;
    for (std::uint64_t i = 1; i <= count; ++i) all.push_back(i);
    return all;
  }

  base::VirtualScheduler time;
  End a{time, 1, 70000, 5h}, b{time, 70000, 1, 9h};
};

TEST_F(Channels, BringAllInOrderAndAcknowledgeAtLast) {
  for (std::uint64_t i = 1; i <= 100; ++i) a.say(i);
  time.run_for(1s);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(100)));
  EXPECT_FALSE(a.channel->unanswered_since());
  EXPECT_EQ(a.channel->waiting(), 0U);
}

TEST_F(Channels, BringTheLastFrameThoughTheBrokerDroppedIt) {
  a.drops = [&](const FrameHead& head) { return head.number == 3 && a.frames <= 3; };
  for (std::uint64_t i = 1; i <= 3; ++i) a.say(i);
  time.run_for(900ms);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(2))) << "no gap shows";
  time.run_for(200ms);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(3)));
}

TEST_F(Channels, WaitLongerWhereItTakesLonger) {
  a.delay = b.delay = 2s;
  for (std::uint64_t i = 1; i <= 20; ++i) {
    a.say(i);
    time.run_for(20s);
  }
  EXPECT_THAT(b.got, ElementsAreArray(up_to(20)));
  EXPECT_LE(a.frames, 24U) << "only the first ones are sent again";
}

TEST_F(Channels, SendAgainFromTheFirstThatIsMissing) {
  a.say(1);
  time.run_for(100ms);
  a.drops = [&](const FrameHead& head) { return head.number == 2 && a.frames <= 2; };
  for (std::uint64_t i = 2; i <= 5; ++i) a.say(i);
  time.run_for(10ms);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(5))) << "the gap is told at once";
}

/// Else 64 bytes could be answered by 8 MiB as often as somebody likes.
TEST_F(Channels, RepeatOnDemandNowAndThenOnly) {
  a.other = nullptr;
  for (std::uint64_t i = 1; i <= 4; ++i) a.say(i);
  ASSERT_EQ(a.frames, 4U);
  FrameHead head;
  head.again = true;
  time.run_for(200ms);
  for (int i = 0; i < 100; ++i) {
    a.channel->arrived(head, {});
    time.run_for(1ms);
  }
  EXPECT_LE(a.frames, 4U + 2 * 4);
  EXPECT_GE(a.frames, 4U + 4);
}

/// Whatever is lost either way, and however often.
TEST_F(Channels, BringAllOnceThroughABrokerThatDropsHalf) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    a.got.clear();
    b.got.clear();
    a.open(100 * seed);
    b.open(100 * seed);
    std::mt19937 random(seed);
    const auto half = [&random](const FrameHead&) { return random() % 2 == 0; };
    a.drops = b.drops = half;
    for (std::uint64_t i = 1; i <= 200; ++i) {
      a.say(i);
      b.say(i);
      if (i % 10 == 0) time.run_for(20ms);
    }
    time.run_for(10min);
    a.drops = b.drops = [](const FrameHead&) { return false; };
    time.run_for(20s);
    EXPECT_THAT(b.got, ElementsAreArray(up_to(200))) << seed;
    EXPECT_THAT(a.got, ElementsAreArray(up_to(200))) << seed;
    EXPECT_FALSE(a.channel->unanswered_since()) << seed;
  }
}

TEST_F(Channels, HaveNoMoreUnderWayThanTheOtherSideTakes) {
  b.credit = 8;
  a.say(1);
  time.run_for(1s);
  a.other = nullptr;
  const auto before = a.frames;
  for (std::uint64_t i = 2; i <= 100; ++i) a.say(i);
  EXPECT_EQ(a.frames - before, 8U);
  EXPECT_GT(a.channel->waiting(), 0U);
}

TEST_F(Channels, DoNotWaitForAcknowledgementsWhereCreditIsLittle) {
  b.credit = 1;
  for (std::uint64_t i = 1; i <= 20; ++i) a.say(i);
  time.run_for(1ms);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(20)));
}

/// Where all of it arrives at once that is 8 MiB, else 512 KiB.
TEST_F(Channels, HaveAsMuchUnderWayAsArrivesInASecond) {
  constexpr std::size_t kFrame = 30'000;
  std::uint64_t last = 0;
  const auto under_way = [&] {
    a.other = nullptr;
    const auto before = a.frames;
    for (int i = 0; i < 400; ++i) a.say(++last, kFrame);
    return (a.frames - before) * kFrame;
  };
  b.credit = Channel::kMaxCredit;
  a.say(++last);
  time.run_for(1s);
  EXPECT_NEAR(static_cast<double>(under_way()), 512 * 1024, kFrame);
  a.other = &b;
  time.run_for(20s);
  for (int i = 0; i < 200; ++i) {
    for (int j = 0; j < 10; ++j) a.say(++last, kFrame);
    time.run_for(10ms);
  }
  EXPECT_GT(under_way(), 7'500'000U) << "256 frames of it";
  a.other = &b;
  time.run_for(1min);
  a.say(++last);
  time.run_for(1s);
  EXPECT_NEAR(static_cast<double>(under_way()), 512 * 1024, kFrame) << "it was slow again";
}

TEST_F(Channels, GoOnWhenTheConnectionIsBack) {
  a.say(1);
  time.run_for(1s);
  a.busy = b.busy = true;
  for (std::uint64_t i = 2; i <= 5; ++i) a.say(i);
  time.run_for(1min);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(1)));
  a.busy = b.busy = false;
  a.channel->reconnected();
  b.channel->reconnected();
  time.run_for(1s);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(5)));
  EXPECT_FALSE(a.channel->unanswered_since());
}

TEST_F(Channels, SayThatNobodyAnswers) {
  a.other = nullptr;
  a.say(1);
  const auto since = time.now();
  time.run_for(1min);
  EXPECT_EQ(a.channel->unanswered_since(), since);
  EXPECT_LE(a.frames, 12U) << "it is sent again more and more seldom";
}

TEST_F(Channels, BeginAnewWhereTheOtherSideMetThisOneAgain) {
  for (std::uint64_t i = 1; i <= 3; ++i) a.say(i), b.say(i);
  time.run_for(1s);
  b.open(2);
  a.say(4);
  b.say(4);
  time.run_for(3s);
  EXPECT_EQ(a.met_again, 1);
  EXPECT_THAT(a.got, ElementsAreArray(up_to(4)));
  EXPECT_THAT(b.got, ElementsAreArray(up_to(4)));
}

TEST_F(Channels, PutManyEntriesIntoAFrameAndALargeOneAlone) {
  a.say(1);
  time.run_for(1s);
  const auto before = a.frames;
  for (std::uint64_t i = 2; i <= 101; ++i) {
    distant::FrameWriter entry;
    entry.add(Reply{a.ends.peer, i, Verdict::kApplied, ErrorCode::kIo, std::string(100, 'x'), 0});
    a.channel->add(entry.take());
  }
  a.channel->flush();
  EXPECT_EQ(a.frames - before, 1U);
  a.say(102, 1'000'000);
  time.run_for(1s);
  EXPECT_GT(a.largest, 1'000'000U);
  EXPECT_THAT(b.got, ElementsAreArray(up_to(102)));
}

/// A request that waits for the connection does not arrive with its whole time.
TEST_F(Channels, LeaveOutRequestsWhoseTimeEnded) {
  a.say(1);
  time.run_for(1s);
  RemoteSet set;
  set.request = 2;
  set.time_to_live = 1s;
  b.credit = 0;  // nothing is said of it
  a.other = nullptr;
  for (int i = 0; i < 64; ++i) a.say(1000);
  a.channel->add(set);
  time.run_for(2s);
  a.other = &b;
  time.run_for(20s);
  EXPECT_THAT(b.got, testing::Not(testing::Contains(2U)));
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
