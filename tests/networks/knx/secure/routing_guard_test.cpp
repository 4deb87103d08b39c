#include "networks/knx/secure/routing_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "base/virtual_scheduler.h"
#include "networks/knx/secure/annotated.h"
#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// ROUTING_INDICATION of a switch to 3/1/5, and one with a temperature.
constexpr std::string_view kSwitch = "0610053000112900bce0442c1905010081";
constexpr std::string_view kTemperature = "0610053000132900bce0110a19070300800c33";
/// Of the worked vectors (knx.md, section 18).
constexpr std::string_view kBackbone = "000102030405060708090a0b0c0d0e0f";
constexpr std::string_view kRoutedWrapper =
    "061009500039000000c0c1c2c3c400fa12345678affeedfddf9307e4b5c3e65ed4d4b40186d324d1a08fa691ee7f363cbee04cc1254139c5f"
    "e";
constexpr std::string_view kRoutedNotify = "06100955002400c0c1c2c3c400fa12345678affe09db04430d08b02da34fd5187ab4d39e";
constexpr std::string_view kVectorFrame = "0610053000132900bcd011c80a070300800c33";
constexpr std::uint64_t kVectorTimer = 0xc0c1c2c3c4;

/// A storage that outlives its users, as the state file does.
struct Shelf {
  GroupStorage storage() {
    return {[this](std::string_view name, ByteView value) -> Result<void> {
              if (broken) return fail(ErrorCode::kIo, "the disk is full");
              values[std::string(name)] = Bytes(value.begin(), value.end());
              ++writes;
              return {};
            },
            [this](std::string_view name) -> Result<std::optional<Bytes>> {
              const auto found = values.find(std::string(name));
              return found == values.end() ? std::optional<Bytes>() : std::optional(found->second);
            }};
  }
  std::map<std::string, Bytes> values;
  int writes = 0;
  bool broken = false;
};

/// A member of a group, and what it sends and says.
struct Member {
  Member(VirtualScheduler& time, std::uint8_t serial, std::uint64_t start = 1000, std::string_view key = kBackbone)
      : Member(time, key, {}, {2s, Serial{serial}, start, serial}) {}
  Member(VirtualScheduler& time, std::string_view key, GroupStorage storage, const RoutingClock::Settings& clock)
      : guard(std::make_unique<RoutingGuard>(time, RoutingKeys{key_of(key), clock.latency}, std::move(storage), clock,
                                             calls())) {}
  Member(VirtualScheduler& time, Shelf& shelf, std::uint8_t first_random) {
    const Random random = [first_random](std::span<std::uint8_t> bytes) -> Result<void> {
      std::fill(bytes.begin(), bytes.end(), first_random);
      return {};
    };
    guard = RoutingGuard::make(time, RoutingKeys{key_of(kBackbone), 2s}, shelf.storage(), random, calls()).value();
  }

  RoutingGuard::Callbacks calls() {
    return {[this](ByteView datagram) { sent.emplace_back(datagram.begin(), datagram.end()); },
            [this] { ++synchronised; },
            [this](std::string_view subject, std::string_view text) {
              notes.push_back(std::string(subject) + ": " + std::string(text));
            }};
  }
  std::string take(const Bytes& datagram) { return base::to_hex(guard->receive("10.0.0.9:3671", datagram)); }
  Bytes wrap(std::string_view frame) {
    const auto wrapped = guard->wrap(hex(frame));
    return wrapped ? Bytes(wrapped->begin(), wrapped->end()) : Bytes{};
  }
  std::uint64_t count(const std::string& name) const { return guard->counters().at(name); }

  std::vector<Bytes> sent;
  std::vector<std::string> notes;
  int synchronised = 0;
  std::unique_ptr<RoutingGuard> guard;
};

/// The timer of a wrapper or a TIMER_NOTIFY.
std::uint64_t timer_of(const Bytes& datagram) {
  const auto frame = wire::read_frame(datagram).value();
  if (frame.service == wire::ServiceCode::kTimerNotify) return read_timer_notify(frame)->timer;
  return read_wrapper(frame)->head.sequence;
}

struct SecureGroup : testing::Test {
  void start(Member& member) {
    member.guard->start();
    time.run_for(7s);
    ASSERT_TRUE(member.guard->synchronised());
  }
  VirtualScheduler time;
};

TEST_F(SecureGroup, MembersReadEachOther) {
  Member ann(time, 1), bob(time, 2);
  start(ann);
  start(bob);
  EXPECT_EQ(bob.take(ann.wrap(kSwitch)), kSwitch);
  EXPECT_EQ(ann.take(bob.wrap(kTemperature)), kTemperature);
  EXPECT_EQ(ann.count("secure-sent"), 1u);
  EXPECT_EQ(ann.count("secure-received"), 1u);
}

TEST_F(SecureGroup, TheWorkedVectorsAreTaken) {
  Member member(time, 1, kVectorTimer - 7000);
  start(member);
  EXPECT_EQ(member.take(hex(kRoutedWrapper)), kVectorFrame);
  EXPECT_EQ(member.take(hex(kRoutedNotify)), "");
  EXPECT_EQ(member.count("secure-notifies-received"), 1u);
  EXPECT_EQ(member.count("secure-wrong-mac"), 0u);
}

TEST_F(SecureGroup, SendsNothingBeforeItIsSynchronised) {
  Member member(time, 1), other(time, 2);
  start(other);
  EXPECT_EQ(member.guard->wrap(hex(kSwitch)).error().code, ErrorCode::kRefused);
  member.guard->start();
  EXPECT_EQ(member.guard->wrap(hex(kSwitch)).error().code, ErrorCode::kRefused);
  EXPECT_EQ(member.take(other.wrap(kSwitch)), "");
  EXPECT_EQ(member.count("secure-early"), 1u);
  time.run_for(7s);
  EXPECT_EQ(member.synchronised, 1);
  EXPECT_EQ(member.take(other.wrap(kSwitch)), kSwitch);
}

TEST_F(SecureGroup, DropsPlainFramesButSearches) {
  Member member(time, 1);
  start(member);
  EXPECT_EQ(member.take(hex(kSwitch)), "");
  EXPECT_EQ(member.count("secure-plain-frames"), 1u);
  EXPECT_THAT(member.notes, Contains(HasSubstr("ROUTING_INDICATION without encryption")));
  const std::string search = "06100201000e08010a4d00019ca4";
  EXPECT_EQ(member.take(hex(search)), search);
}

TEST_F(SecureGroup, DropsRepetitionsWithinTheTolerance) {
  Member ann(time, 1), bob(time, 2);
  start(ann);
  start(bob);
  const auto first = ann.wrap(kSwitch), second = ann.wrap(kSwitch);
  EXPECT_EQ(bob.take(first), kSwitch);
  EXPECT_EQ(bob.take(second), kSwitch) << "equal content with another tag is no repetition";
  time.run_for(500ms);
  EXPECT_EQ(bob.take(first), "");
  EXPECT_EQ(bob.count("secure-replays"), 1u);
  time.run_for(3s);
  EXPECT_EQ(bob.take(first), "");
  EXPECT_EQ(bob.count("secure-old"), 1u);
}

TEST_F(SecureGroup, RemembersABoundedNumberOfWrappersWithoutALoophole) {
  Member ann(time, 1), bob(time, 2);
  start(ann);
  start(bob);
  const auto first = ann.wrap(kSwitch);
  EXPECT_EQ(bob.take(first), kSwitch);
  time.run_for(1ms);
  for (std::size_t i = 0; i < RoutingGuard::kMaxRemembered; ++i) ASSERT_EQ(bob.take(ann.wrap(kSwitch)), kSwitch);
  EXPECT_EQ(bob.take(first), "") << "it is forgotten, and refused by its time";
  EXPECT_EQ(bob.count("secure-replays"), 1u);
}

TEST_F(SecureGroup, WhatIsNotAuthenticHasNoEffect) {
  Member ann(time, 1, 100'000'000), bob(time, 2), eve(time, 3, 900'000'000, "ffffffffffffffffffffffffffffffff");
  start(ann);
  start(bob);
  start(eve);
  const auto timer = timer_of(bob.wrap(kSwitch));
  auto changed = ann.wrap(kSwitch);
  changed.back() ^= 1;
  EXPECT_EQ(bob.take(changed), "");
  EXPECT_EQ(bob.take(eve.wrap(kSwitch)), "");
  auto notify = ann.sent.at(0);
  notify[8] ^= 0x40;
  EXPECT_EQ(bob.take(notify), "");
  EXPECT_EQ(bob.count("secure-wrong-mac"), 3u);
  EXPECT_EQ(timer_of(bob.wrap(kSwitch)), timer) << "the timer was not taken over";
  EXPECT_THAT(bob.guard->problem(), HasSubstr("another backbone key"));
  EXPECT_EQ(bob.take(ann.wrap(kSwitch)), kSwitch);
  EXPECT_EQ(bob.guard->problem(), "");
}

TEST_F(SecureGroup, KnowsItsOwnFrames) {
  Member member(time, 1);
  member.guard->start();
  ASSERT_THAT(member.sent, SizeIs(1));
  EXPECT_EQ(member.take(member.sent[0]), "");
  EXPECT_FALSE(member.guard->synchronised()) << "our own question is no answer";
  time.run_for(7s);
  EXPECT_EQ(member.take(member.wrap(kSwitch)), "");
  EXPECT_EQ(member.count("secure-own-frames"), 2u);
  EXPECT_THAT(member.guard->problem(), HasSubstr("no other member"));
}

TEST_F(SecureGroup, AMemberThatIsLateIsCorrected) {
  Member ann(time, 1, 500'000), bob(time, 2, 7);
  start(ann);
  bob.guard->start();
  ann.take(bob.sent.at(0));
  time.run_for(1s);
  ASSERT_THAT(ann.sent, SizeIs(2));
  bob.take(ann.sent[1]);
  EXPECT_TRUE(bob.guard->synchronised());
  EXPECT_EQ(ann.take(bob.wrap(kSwitch)), kSwitch);
}

TEST_F(SecureGroup, RubbishIsCountedAndDropped) {
  Member member(time, 1);
  start(member);
  for (const auto* rubbish : {"", "0610", "06100950000600", "061009500006", "061009550006", "0610095000080000"})
    EXPECT_EQ(member.take(hex(rubbish)), "") << rubbish;
  EXPECT_EQ(member.count("secure-bad-frames"), 6u);
}

TEST_F(SecureGroup, TheTimerRisesOverRestarts) {
  Shelf shelf;
  std::uint64_t last = 0;
  const auto use = [&](std::uint8_t serial, bool killed) {
    auto member = std::make_unique<Member>(time, shelf, serial);
    const auto kept = shelf.values;
    member->guard->start();
    time.run_for(7s);
    const auto begin = timer_of(member->wrap(kSwitch));
    EXPECT_GT(begin, last);
    for (int i = 0; i < 30; ++i) {
      time.run_for(1min);
      last = timer_of(member->wrap(kSwitch));
    }
    const auto written = shelf.values;
    member.reset();
    if (killed) shelf.values = written;  // without what the destructor stores
    return begin;
  };
  use(1, false);
  const auto before = last;
  time.run_for(1h);
  EXPECT_GE(use(2, true), before + 3'600'000) << "the time of the pause is added";
  use(3, true);
  use(4, false);
  EXPECT_LT(shelf.writes, 40) << "each ten minutes and at the end";
}

TEST_F(SecureGroup, TheTimerRisesThoughTheClockWasSetBack) {
  Shelf shelf;
  std::uint64_t last = 0;
  {
    Member member(time, shelf, 1);
    start(member);
    time.run_for(5min);
    last = timer_of(member.wrap(kSwitch));
    shelf.broken = true;  // killed: nothing is stored at the end
  }
  shelf.broken = false;
  time.set_wall(time.wall_now() - 24h * 365);
  Member member(time, shelf, 2);
  start(member);
  EXPECT_GT(timer_of(member.wrap(kSwitch)), last);
}

TEST_F(SecureGroup, AFullDiskIsSaidAndDoesNotStopTheLine) {
  Shelf shelf;
  shelf.broken = true;
  Member member(time, shelf, 1);
  start(member);
  EXPECT_FALSE(member.wrap(kSwitch).empty());
  EXPECT_THAT(member.notes, Contains(HasSubstr("the disk is full")));
}

TEST_F(SecureGroup, AfterAFailureTheTimerIsStoredSoon) {
  Shelf shelf;
  shelf.broken = true;
  Member member(time, shelf, 1);
  start(member);
  member.wrap(kSwitch);
  shelf.broken = false;
  time.run_for(15s);
  member.wrap(kSwitch);
  ASSERT_FALSE(shelf.values.empty());
}

TEST_F(SecureGroup, ItsEndCallsNobody) {
  Shelf shelf;
  Member member(time, shelf, 1);
  start(member);
  shelf.broken = true;
  member.guard.reset();
  EXPECT_THAT(member.notes, IsEmpty());
}

/// Every member would take over a timer at its end, and keep it for ever.
TEST_F(SecureGroup, AStoredTimerThatIsDamagedIsNotUsed) {
  for (const std::size_t at : {0U, 7U, 8U, 16U, 23U, 31U}) {
    Shelf shelf;
    {
      Member member(time, shelf, 1);
      start(member);
    }
    ASSERT_FALSE(shelf.values.empty());
    auto& row = shelf.values.begin()->second;
    if (at < row.size()) row[at] ^= 0x80;
    Member member(time, shelf, 2);
    start(member);
    EXPECT_LT(timer_of(member.wrap(kSwitch)), 60'000U) << at;
    EXPECT_THAT(member.notes, Contains(HasSubstr("cannot be used"))) << at;
  }
}

TEST_F(SecureGroup, AWallClockThatWasFarAheadCostsTenYearsOfTheTimer) {
  Shelf shelf;
  {
    Member member(time, shelf, 1);
    start(member);
  }
  time.set_wall(time.wall_now() + 24h * 365 * 100);
  Member member(time, shelf, 2);
  start(member);
  const auto years = std::chrono::milliseconds(timer_of(member.wrap(kSwitch))) / (24h * 365);
  EXPECT_GE(years, 9);
  EXPECT_LE(years, 11);
}

TEST_F(SecureGroup, AtTheEndOfTheTimerNothingIsSent) {
  Member member(time, 1, RoutingClock::kMaxTimer - 8'000);
  start(member);
  EXPECT_FALSE(member.wrap(kSwitch).empty());
  time.run_for(10s);
  const auto refused = member.guard->wrap(hex(kSwitch));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("timer"));
}

/// A restarted member whose timer is behind that of the group takes nothing that was sent before its start.
TEST_F(SecureGroup, WhatWasTakenBeforeARestartIsNotTakenAgain) {
  Member ann(time, 1, 500'000), bob(time, 2, 500'000);
  start(ann);
  start(bob);
  const auto first = ann.wrap(kSwitch);
  ASSERT_EQ(bob.take(first), kSwitch);
  Member again(time, 3, 7);
  again.guard->start();
  const auto asked = ann.sent.size();
  ann.take(again.sent.at(0));
  time.run_for(310ms);
  ASSERT_GT(ann.sent.size(), asked);
  again.take(ann.sent.back());
  ASSERT_TRUE(again.guard->synchronised());
  EXPECT_EQ(again.take(first), "");
  EXPECT_EQ(again.count("secure-early"), 1U);
  time.run_for(1ms);
  EXPECT_EQ(again.take(ann.wrap(kSwitch)), kSwitch);
}

TEST_F(SecureGroup, EarlyFramesHaveASenderInTheLog) {
  Member member(time, 1), other(time, 2);
  start(other);
  member.guard->start();
  member.take(other.wrap(kSwitch));
  EXPECT_THAT(member.notes, Contains(AllOf(HasSubstr("secure-early"), HasSubstr("10.0.0.9"))));
}

TEST_F(SecureGroup, ForbiddenContentIsNotReceived) {
  Member ann(time, 1), bob(time, 2);
  start(ann);
  start(bob);
  EXPECT_EQ(bob.take(ann.wrap("061007400006")), "");
  EXPECT_EQ(bob.count("secure-forbidden"), 1U);
  EXPECT_EQ(bob.count("secure-received"), 0U);
}

TEST_F(SecureGroup, AFrameWithOurSerialAndAWrongMacIsForged) {
  Member member(time, 1);
  start(member);
  auto forged = member.wrap(kSwitch);
  forged.back() ^= 1;
  EXPECT_EQ(member.take(forged), "");
  EXPECT_EQ(member.count("secure-wrong-mac"), 1U);
}

struct RecordedRow {
  double seconds = 0;
  std::string kind, label, hex_text, note;
};

std::vector<RecordedRow> recorded() {
  std::vector<RecordedRow> rows;
  std::ifstream file(shared_data("knx-secure/secure/routing.tsv"));
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    for (std::size_t at = 0, tab = 0; tab != line.npos; at = tab + 1) {
      tab = line.find('\t', at);
      cells.push_back(line.substr(at, tab == line.npos ? tab : tab - at));
    }
    cells.resize(5);
    rows.push_back({std::stod(cells[0]), cells[1], cells[2], cells[3], cells[4]});
  }
  return rows;
}

bool is_refused(const std::string& note) {
  for (const auto* word : {"too old", "the very same", "changed MAC", "another backbone key", "plain ROUTING"})
    if (note.find(word) != note.npos) return true;
  return false;
}

/// A member whose timer is that of the recorded server: 11,180 after 0.275 s.
TEST_F(SecureGroup, TheRecordedParticipantIsTakenOrDroppedAsAnnotated) {
  const auto rows = recorded();
  if (rows.empty()) GTEST_SKIP() << "no ../shared/data/knx-secure";
  Member server(time, rows[0].hex_text, {}, {1500ms, Serial{0xba, 0x4d}, 905, 1});
  server.guard->start();
  time.run_for(10s);
  ASSERT_TRUE(server.guard->synchronised());
  const auto begin = time.now();
  std::size_t taken = 0, dropped = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].kind != "C") continue;
    time.run_for(begin + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(rows[i].seconds)) -
                 time.now());
    const auto got = server.take(hex(rows[i].hex_text));
    if (rows[i].label == "TIMER_NOTIFY") continue;
    if (is_refused(rows[i].note)) {
      EXPECT_EQ(got, "") << rows[i].note;
      ++dropped;
    } else {
      ASSERT_EQ(rows[i + 1].kind, "plain");
      EXPECT_EQ(got, rows[i + 1].hex_text) << rows[i].note;
      ++taken;
    }
  }
  EXPECT_EQ(taken, 5u);
  EXPECT_EQ(dropped, 5u);
  EXPECT_EQ(server.count("secure-wrong-mac"), 3u);
  EXPECT_EQ(server.count("secure-replays"), 1u);
  EXPECT_EQ(server.count("secure-old"), 1u);
  EXPECT_EQ(server.count("secure-plain-frames"), 1u);
}

/// Keys, blocks and MACs of both sides: every frame but those that the participant spoilt is made again from its
/// annotated values.
TEST_F(SecureGroup, TheRecordedFramesAreReproducedByteForByte) {
  const auto rows = recorded();
  if (rows.empty()) GTEST_SKIP() << "no ../shared/data/knx-secure";
  const auto key = key_of(rows[0].hex_text);
  Ccm ccm;
  int made = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& row = rows[i];
    if (row.note.find("changed MAC") != row.note.npos || row.note.find("another") != row.note.npos) continue;
    if (row.label == "SECURE_WRAPPER") {
      const auto bytes = hex(row.hex_text);
      const auto head = read_wrapper(wire::read_frame(bytes).value())->head;
      ASSERT_EQ(rows[i + 1].kind, "plain");
      Bytes again;
      ASSERT_TRUE(seal_wrapper(ccm, key, head, hex(rows[i + 1].hex_text), again));
      EXPECT_EQ(base::to_hex(again), row.hex_text);
      ++made;
    } else if (row.label == "TIMER_NOTIFY") {
      const auto bytes = hex(row.hex_text);
      const auto notify = read_timer_notify(wire::read_frame(bytes).value()).value();
      Block mac{};
      const auto nonce = nonce_of({0, notify.timer, notify.serial, notify.tag}, 0);
      ASSERT_TRUE(ccm.seal(key, nonce, ByteView(bytes).first(wire::kHeaderSize), {}, mac));
      EXPECT_EQ(mac, notify.mac) << row.hex_text;
      ++made;
    }
  }
  EXPECT_EQ(made, 25);
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
