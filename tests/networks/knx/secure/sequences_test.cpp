#include "networks/knx/secure/sequences.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "networks/knx/secure/guard_bench.h"

namespace rubicon::networks::knx::secure {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr auto kYear = std::chrono::hours(365 * 24);

TEST(OwnSequence, BeginsWithTheMillisecondsSince2018) {
  VirtualScheduler time;
  Disk disk;
  time.set_wall(std::chrono::sys_days{std::chrono::year{2026} / 1 / 5} + 90s);  // 2,922 days later
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_EQ(own.next(), 2922 * 86'400'000ULL + 90'000);
  EXPECT_EQ(own.next(), 2922 * 86'400'000ULL + 90'001);
}

/// With small numbers all devices would ignore us until the clock is right.
TEST(OwnSequence, DoesNotBeginWithAClockThatWasNeverSet) {
  VirtualScheduler time;
  Disk disk;
  const auto right = time.wall_now();
  time.set_wall({});  // 1970: no battery
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_THAT(own.next().error().text, HasSubstr("the clock of this host was never set"));
  EXPECT_THAT(own.usable().error().text, HasSubstr("the clock of this host was never set"));
  EXPECT_EQ(disk.writes, 0);
  time.set_wall(right);
  EXPECT_TRUE(own.usable());
  EXPECT_TRUE(own.next());
}

TEST(OwnSequence, NeedsNoClockWhereALastNumberIsKnown) {
  VirtualScheduler time;
  Disk disk;
  time.set_wall({});
  OwnSequence known(time, disk.storage(), 700);
  EXPECT_EQ(known.next(), 701U);
  OwnSequence stored(time, disk.storage(), 0);
  EXPECT_EQ(stored.next(), 1701U);
}

/// A host without a battery starts with an old clock, and the network sets it seconds later.
TEST(OwnSequence, FollowsAClockThatIsSetLater) {
  VirtualScheduler time;
  Disk disk;
  disk.store_own(5000);
  const auto right = time.wall_now();
  time.set_wall({});
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_EQ(own.next(), 5001U);
  time.set_wall(right);
  const auto since_2018 = std::chrono::duration_cast<std::chrono::milliseconds>(
      right - std::chrono::sys_days{std::chrono::year{2018} / 1 / 5});
  EXPECT_EQ(own.next(), static_cast<std::uint64_t>(since_2018.count()));
  EXPECT_EQ(disk.writes, 2);
}

TEST(OwnSequence, IsStoredAtMostEachMinuteForTheClock) {
  VirtualScheduler time;
  Disk disk;
  OwnSequence own(time, disk.storage(), 0);
  for (int i = 0; i < 600; ++i) {
    ASSERT_TRUE(own.next());
    time.run_for(1s);
  }
  EXPECT_LE(disk.writes, 10);
}

TEST(OwnSequence, ReservesAThousandNumbersAtATime) {
  VirtualScheduler time;
  Disk disk;
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_EQ(disk.writes, 0) << "nothing is reserved before it is needed";
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(own.next());
  EXPECT_EQ(disk.writes, 1);
  EXPECT_TRUE(own.next());
  EXPECT_EQ(disk.writes, 2);
}

TEST(OwnSequence, ContinuesBehindTheReservationAfterTheClockWasSetBackByAYear) {
  VirtualScheduler time;
  Disk disk;
  std::uint64_t last = 0;
  {
    OwnSequence own(time, disk.storage(), 0);
    for (int i = 0; i < 10; ++i) last = own.next().value();
  }
  time.set_wall(time.wall_now() - kYear);
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_EQ(own.next(), last - 9 + OwnSequence::kReserve);
}

TEST(OwnSequence, AClockThatGoesBackInARunningProgramChangesNothing) {
  VirtualScheduler time;
  Disk disk;
  OwnSequence own(time, disk.storage(), 0);
  std::uint64_t last = 0;
  for (int i = 0; i < 5000; ++i) {
    if (i == 2500) time.set_wall(time.wall_now() - kYear);
    const auto next = own.next().value();
    ASSERT_GT(next, last);
    last = next;
  }
}

TEST(OwnSequence, EndsAtTheLargestNumber) {
  VirtualScheduler time;
  Disk disk;
  disk.store_own(kMaxSequence - 2);
  OwnSequence own(time, disk.storage(), 0);
  EXPECT_EQ(own.next(), kMaxSequence - 1);
  EXPECT_EQ(own.next(), kMaxSequence);
  const auto none = own.next();
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kOutOfRange);
  OwnSequence again(time, disk.storage(), 0);
  EXPECT_EQ(again.next().error().code, ErrorCode::kOutOfRange);
}

TEST(OwnSequence, AReadThatFailsOnceIsTriedAgain) {
  VirtualScheduler time;
  Disk disk;
  disk.store_own(kMaxSequence - 10);
  auto storage = disk.storage();
  bool broken = true;
  storage.stored = [&, read = storage.stored](std::string_view name) -> Result<std::optional<Bytes>> {
    if (broken) return fail(ErrorCode::kIo, "state file is locked");
    return read(name);
  };
  OwnSequence own(time, storage, 0);
  EXPECT_THAT(own.next().error().text, HasSubstr("state file is locked"));
  broken = false;
  EXPECT_EQ(own.next(), kMaxSequence - 9);
}

/// The program on a machine whose power fails at any point, whose disk fails before or after it wrote, whose clock is
/// set back, and whose old files are restored.
class UnluckyMachine {
 public:
  explicit UnluckyMachine(unsigned seed) : random_(seed) { boot(); }

  /// Uses a number, or fails to. False: a number came twice, or went back.
  bool use() {
    time_.run_for(std::chrono::milliseconds(1 + draw(50)));
    const auto next = own_->next();
    if (!next) return true;
    if (*next == 0 || *next > kMaxSequence || !used_.insert(*next).second) return false;
    const bool rises = *next > largest_;
    largest_ = *next;
    return rises;
  }
  void crash() { boot(); }
  /// With the storage intact, the clock may say anything.
  void set_clock_back() {
    time_.set_wall(time_.wall_now() - kYear);
    clock_is_right_ = false;
  }
  void set_clock_right() {
    time_.set_wall(WallTime{} + 56 * kYear +
                   std::chrono::duration_cast<std::chrono::microseconds>(time_.now().time_since_epoch()));
    clock_is_right_ = true;
  }
  void back_up() { saved_ = disk_; }
  /// Only with the right clock, until the next number: nothing else knows what was used since. False as use().
  bool restore_backup() {
    if (!clock_is_right_ || largest_ >= now()) return true;
    disk_ = saved_;
    boot();
    const auto before = used_.size();
    while (used_.size() == before) {
      if (!use()) return false;
    }
    return true;
  }
  unsigned draw(unsigned below) { return std::uniform_int_distribution<unsigned>(0, below - 1)(random_); }
  std::size_t used() const { return used_.size(); }

 private:
  std::uint64_t now() const {
    const std::chrono::sys_days epoch = std::chrono::year{2018} / 1 / 5;
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(time_.wall_now() - epoch).count());
  }
  void boot() {
    own_.reset();
    GroupStorage storage;
    storage.stored = [this](std::string_view) -> Result<std::optional<Bytes>> {
      if (draw(8) == 0) return fail(ErrorCode::kIo, "cannot read");
      return disk_;
    };
    storage.store = [this](std::string_view, ByteView value) -> Result<void> {
      const auto luck = draw(8);
      if (luck == 0) return fail(ErrorCode::kIo, "failed before the write");
      disk_ = Bytes(value.begin(), value.end());
      if (luck == 1) return fail(ErrorCode::kIo, "failed after the write");
      return {};
    };
    own_ = std::make_unique<OwnSequence>(time_, std::move(storage), 0);
  }

  std::mt19937 random_;
  VirtualScheduler time_;
  std::optional<Bytes> disk_, saved_;
  std::unique_ptr<OwnSequence> own_;
  std::set<std::uint64_t> used_;
  std::uint64_t largest_ = 0;
  bool clock_is_right_ = true;
};

TEST(OwnSequence, NoNumberComesTwiceWhateverCrashesOrIsRestored) {
  std::size_t used = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    UnluckyMachine machine(seed);
    for (int step = 0; step < 1000; ++step) {
      switch (machine.draw(40)) {
        case 0: machine.crash(); break;
        case 1: machine.set_clock_back(); break;
        case 2:
        case 3: machine.set_clock_right(); break;
        case 4: machine.back_up(); break;
        case 5: ASSERT_TRUE(machine.restore_backup()) << "seed " << seed << ", step " << step; break;
        case 6:
          for (int i = 0; i < 1100; ++i) ASSERT_TRUE(machine.use()) << "seed " << seed << ", step " << step;
          break;
        default: ASSERT_TRUE(machine.use()) << "seed " << seed << ", step " << step;
      }
    }
    used += machine.used();
  }
  EXPECT_GT(used, 300U * 5000U) << "the machine must work most of the time";
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
