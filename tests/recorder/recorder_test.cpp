#include "recorder/recorder.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "recording/recording_reader.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::recorder {
namespace {

using namespace std::chrono_literals;
using recording::RecordKind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr OwnerId kRecordedIsland{6541};

/// What a file holds: `set key=value`, marks as `mark start`.
struct Content {
  std::vector<std::string> lines;
  std::vector<recording::Damage> damage;
  std::size_t blocks = 0;

  std::vector<std::string> sets() const {
    std::vector<std::string> out;
    for (const auto& line : lines) {
      if (line.starts_with("set ") || line.starts_with("deleted ") || line.starts_with("expired ")) out.push_back(line);
    }
    return out;
  }
};

Content content_of(const Bytes& bytes) {
  Content content;
  recording::RecordingReader reader;
  reader.feed(bytes);
  reader.end();
  while (auto item = reader.next()) {
    if (std::holds_alternative<recording::BlockFound>(*item)) ++content.blocks;
    if (const auto* damage = std::get_if<recording::Damage>(&*item)) content.damage.push_back(*damage);
    const auto* record = std::get_if<recording::Record>(&*item);
    if (record == nullptr) continue;
    auto line = std::string(to_string(record->kind)) + " ";
    if (record->kind != RecordKind::kMark) line += std::string(record->key) + "=";
    content.lines.push_back(line + std::string(record->value));
  }
  return content;
}

class Recording : public testing::Test {
 protected:
  config::RecorderSetup setup() const {
    config::RecorderSetup one;
    one.name = "all";
    one.file = "home.rec";
    one.patterns = {*Pattern::parse("proxy.**")};
    return one;
  }
  std::unique_ptr<Recorder> start(const config::RecorderSetup& one) {
    auto recorder = std::make_unique<Recorder>(one, Recorder::Context{time, space, disk, log, "proxy", "rec"});
    recorder->start();
    time.run_ready();
    return recorder;
  }
  void set(const std::string& key, std::string_view value) {
    ASSERT_TRUE(space.set(key, value));
    time.run_ready();
  }
  Content content() { return content_of(disk.bytes("rec/home.rec")); }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<tuples::Link> link = *ecology.join(kRecordedIsland);
  TupleSpace space{kRecordedIsland, time, *link};
  transport::MemoryTransports disk;
  support::CollectingLog log;
};

TEST_F(Recording, HoldsEachSetDeletionAndExpiryInOrder) {
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  set("proxy.a.value", "1");
  set("other", "x");
  ASSERT_TRUE(space.set("proxy.b.value", "2", {"text/plain", {}, 300ms}));
  time.run_for(500ms);
  ASSERT_TRUE(space.erase("proxy.a.value"));
  time.run_for(2s);
  EXPECT_THAT(content().sets(), ElementsAre("set proxy.a.value=1", "set proxy.a.value=1", "set proxy.b.value=2",
                                            "expired proxy.b.value=2", "deleted proxy.a.value=1"));
  EXPECT_THAT(content().lines.front(), "mark start");
  EXPECT_EQ(recorder->counters().dropped, 0u);
  EXPECT_EQ(recorder->counters().records, content().lines.size());
}

TEST_F(Recording, ACrashLosesAtMostTheLastSecond) {
  auto recorder = start(setup());
  for (int i = 0; i < 50; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(100ms);
  }
  // What the disk has now is all that a crash leaves.
  const auto sets = content().sets();
  EXPECT_GE(sets.size(), 40u);
  EXPECT_EQ(sets.back(), "set proxy.a.value=" + std::to_string(sets.size() - 1));
  EXPECT_LE(content().blocks, 7u);
}

TEST_F(Recording, WritesABlockWhenItIsFullAndTheLastOneAtItsEnd) {
  auto recorder = start(setup());
  time.run_for(2s);
  const auto before = content().blocks;
  for (int i = 0; i < 3; ++i) set("proxy.a.value", std::string(100'000, 'x'));
  EXPECT_EQ(content().blocks, before + 1);
  set("proxy.a.value", "end");
  EXPECT_NE(content().sets().back(), "set proxy.a.value=end");
  recorder.reset();
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=end");
}

TEST_F(Recording, TouchesNoFileBeforeItStarts) {
  const Recorder recorder(setup(), {time, space, disk, log, "proxy", "rec"});
  set("proxy.a.value", "1");
  time.run_for(5s);
  EXPECT_THAT(disk.paths(), IsEmpty());
}

TEST_F(Recording, BeginsWithASnapshotOfWhatIsThere) {
  set("proxy.a.value", "1");
  set("proxy.b.value", "2");
  auto recorder = start(setup());
  time.run_for(2s);
  const auto lines = content().lines;
  EXPECT_THAT(lines, testing::IsSupersetOf(
                         {"mark start", "present proxy.a.value=1", "present proxy.b.value=2", "mark complete"}));
}

TEST_F(Recording, GoesOnInTheSameFileAndCutsADamagedTail) {
  start(setup());
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  recorder.reset();
  auto bytes = disk.bytes("rec/home.rec");
  const auto sound = bytes.size();
  for (int i = 0; i < 100; ++i) bytes.push_back(0xf3);
  disk.put("rec/home.rec", bytes);
  recorder = start(setup());
  EXPECT_EQ(disk.bytes("rec/home.rec")[sound + 1], 'R') << "no block begins where the sound ones ended";
  EXPECT_EQ(recorder->counters().cut, 100u);
  EXPECT_TRUE(log.contains("100 damaged bytes at the end of the file were cut off"));
  set("proxy.a.value", "2");
  recorder.reset();
  EXPECT_THAT(content().damage, IsEmpty());
  EXPECT_THAT(content().sets(), testing::IsSupersetOf({"set proxy.a.value=1", "set proxy.a.value=2"}));
}

TEST_F(Recording, ATruncatedFileOfAnyLengthIsTakenUp) {
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  recorder.reset();
  const auto whole = disk.bytes("rec/home.rec");
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    disk.put("rec/home.rec", Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    recorder = start(setup());
    set("proxy.a.value", "2");
    recorder.reset();
    EXPECT_THAT(content().damage, IsEmpty()) << size;
    EXPECT_EQ(content().sets().back(), "set proxy.a.value=2") << size;
  }
}

TEST_F(Recording, AFileThatIsNoRecordingIsLeftAlone) {
  disk.put("rec/home.rec", std::string_view("time,temperature\n0,20\n"));
  const auto before = disk.bytes("rec/home.rec");
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  time.run_for(5s);
  recorder.reset();
  EXPECT_EQ(disk.bytes("rec/home.rec"), before);
  EXPECT_TRUE(log.contains("rec/home.rec: is not a recording"));
}

TEST_F(Recording, ARecordingOfAnotherIslandIsLeftAlone) {
  disk.put("rec/home.rec", recording::encode_head({OwnerId(7), "proxy", {}, "x"}));
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  time.run_for(5s);
  EXPECT_TRUE(log.contains("expected island 6541 with prefix proxy"));
  EXPECT_GT(recorder->counters().dropped, 0u);
}

TEST_F(Recording, AFullDiskLosesNothingButWhatItDoesNotTake) {
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  time.run_for(2s);
  disk.room(10);
  set("proxy.a.value", "2");
  time.run_for(3s);
  EXPECT_EQ(recorder->counters().dropped, 1u);
  EXPECT_TRUE(log.contains("No space left on device"));
  EXPECT_THAT(content().damage, IsEmpty()) << "a part of a block was left behind";
  disk.room(std::nullopt);
  set("proxy.a.value", "3");
  time.run_for(3s);
  EXPECT_THAT(content().sets(), ElementsAre("set proxy.a.value=1", "set proxy.a.value=3"));
  EXPECT_THAT(content().lines, testing::Contains("mark snapshot")) << "what was missed must be made up for";
}

TEST_F(Recording, APartThatCannotBeCutOffIsCutOffLater) {
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  time.run_for(2s);
  disk.room(10);
  disk.refuse_cuts(true);
  set("proxy.a.value", "2");
  time.run_for(2s);
  EXPECT_FALSE(content().damage.empty());
  disk.room(std::nullopt);
  disk.refuse_cuts(false);
  set("proxy.a.value", "3");
  time.run_for(3s);
  EXPECT_THAT(content().damage, IsEmpty());
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=3");
}

TEST_F(Recording, SaysWhatItDropsWhileItDropsAndWhenItGoesOn) {
  auto recorder = start(setup());
  set("proxy.a.value", "1");
  time.run_for(2s);
  EXPECT_EQ(recorder->state(), "recording");
  disk.room(0);
  const auto lines = [this](std::string_view part) {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [part](const auto& line) { return line.find(part) != line.npos; });
  };
  for (int i = 0; i < 28; ++i) {
    for (int k = 0; k < 100; ++k) set("proxy.a.value", std::to_string(k));
    time.run_for(1s);
  }
  EXPECT_EQ(lines("No space left on device; records are dropped until it can be written"), 1);
  EXPECT_EQ(lines(" records dropped in "), 2) << "each ten seconds";
  EXPECT_THAT(recorder->state(), HasSubstr("dropping records: "));
  EXPECT_THAT(recorder->state(), HasSubstr("No space left on device"));
  const auto dropped = recorder->counters().dropped;
  EXPECT_GT(dropped, 2500u);
  EXPECT_EQ(lines("continues"), 0);
  disk.room(std::nullopt);
  for (int i = 0; i < 60; ++i) {
    set("proxy.a.value", "last");
    time.run_for(1s);
  }
  EXPECT_EQ(recorder->state(), "recording");
  EXPECT_TRUE(log.contains("rec/home.rec: the recording continues; " + std::to_string(recorder->counters().dropped) +
                           " records were dropped in "));
  EXPECT_THAT(content().damage, IsEmpty());
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=last");
  EXPECT_THAT(content().lines, testing::Contains("mark snapshot"));
}

TEST_F(Recording, AMissingFolderIsToldOnceAMinuteAndTriedAgain) {
  disk.lose_folder("rec");
  auto recorder = start(setup());
  for (int i = 0; i < 50; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(1s);
  }
  const auto failures_logged = [this] {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [](const auto& line) { return line.find("records are dropped until") != line.npos; });
  };
  EXPECT_EQ(failures_logged(), 1);
  EXPECT_GT(recorder->counters().dropped, 40u);
  EXPECT_GE(recorder->counters().failures, 5u);
  EXPECT_LE(recorder->counters().failures, 7u) << "the pauses must double";
  disk.give_folder("rec");
  for (int i = 0; i < 62; ++i) {
    set("proxy.a.value", "last");
    time.run_for(1s);
  }
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=last");
}

TEST_F(Recording, ADiskThatIsNearlyFullIsLeftInPeace) {
  std::uint32_t noise = 1;
  for (int i = 0; i < 20; ++i) {
    std::string value(1000, ' ');
    for (auto& c : value) c = static_cast<char>(33 + ((noise = noise * 1664525 + 1013904223) >> 24) % 90);
    set("proxy.many." + std::to_string(i), value);
  }
  auto recorder = start(setup());
  time.run_for(2s);
  const auto run = [&](int seconds) {
    for (int i = 0; i < seconds; ++i) {
      set("proxy.a.value", std::to_string(i));
      time.run_for(1s);
    }
  };
  // Somebody frees a little each second: enough for a reading, not for a snapshot.
  const auto before = recorder->counters();
  for (int i = 0; i < 600; ++i) {
    disk.room(1000);
    run(1);
  }
  EXPECT_LE(recorder->counters().failures - before.failures, 16u);
  const auto goes_on = [this] {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [](const auto& line) { return line.find("continues") != line.npos; });
  };
  EXPECT_LE(goes_on(), 11);
  disk.room(std::nullopt);
  run(180);
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=179");
  const auto soon = recorder->counters().failures;
  disk.room(0);
  run(1);
  disk.room(std::nullopt);
  run(4);
  EXPECT_EQ(recorder->counters().failures, soon + 1);
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=3") << "after a good minute the pauses begin with the shortest";
}

TEST_F(Recording, AFileThatSaysItWasBegunAtAnImpossibleTimeIsRotatedLater) {
  for (const auto created : {WallTime::min(), WallTime::max()}) {
    disk.put("rec/home.rec", recording::encode_head({kRecordedIsland, "proxy", created, "x"}));
    auto one = setup();
    one.rotation = {std::nullopt, 1h, 3};
    auto recorder = start(one);
    set("proxy.a.value", "1");
    time.run_for(61min);
    set("proxy.a.value", "2");
    time.run_for(2s);
    // The one from before all calendars at once, and each after an hour.
    EXPECT_EQ(recorder->counters().files, created == WallTime::min() ? 2u : 1u);
    recorder.reset();
    for (const auto& path : disk.paths()) disk.remove(path);
  }
}

TEST_F(Recording, RotatesBySizeAndKeepsTheNewest) {
  auto one = setup();
  one.rotation = {64 << 10, std::nullopt, 3};
  auto recorder = start(one);
  std::uint32_t noise = 1;
  for (int i = 0; i < 40; ++i) {
    std::string value(20'000, ' ');
    for (auto& c : value) c = static_cast<char>(33 + ((noise = noise * 1664525 + 1013904223) >> 24) % 90);
    set("proxy.a.value", value);
    time.run_for(1500ms);
  }
  recorder.reset();
  const auto paths = disk.paths();
  ASSERT_EQ(paths.size(), 4u) << testing::PrintToString(paths);
  EXPECT_THAT(paths[0], testing::MatchesRegex("rec/home-20260101T[0-9]{6}\\.[0-9]{6}Z\\.rec"));
  EXPECT_EQ(paths[3], "rec/home.rec");
  std::size_t sets = 0;
  for (const auto& path : paths) {
    const auto part = content_of(disk.bytes(path));
    sets += part.sets().size();
    EXPECT_THAT(part.damage, IsEmpty());
    EXPECT_EQ(part.lines.front(), "mark snapshot") << "each file stands for itself";
    EXPECT_THAT(part.lines, testing::Contains("mark complete"));
  }
  EXPECT_GT(sets, 6u);
}

TEST_F(Recording, RotatesByTimeAndNamesFilesByTheirFirstRecord) {
  auto one = setup();
  one.rotation = {std::nullopt, 1h, std::nullopt};
  auto recorder = start(one);
  for (int i = 0; i < 5; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(31min);
  }
  recorder.reset();
  EXPECT_THAT(disk.paths(),
              ElementsAre("rec/home-20260101T000000.000000Z.rec", HasSubstr("rec/home-20260101T01"), "rec/home.rec"));
  std::vector<std::string> sets;
  for (const auto& path : disk.paths()) {
    for (auto& line : content_of(disk.bytes(path)).sets()) sets.push_back(line);
  }
  EXPECT_THAT(sets, ElementsAre("set proxy.a.value=0", "set proxy.a.value=1", "set proxy.a.value=2",
                                "set proxy.a.value=3", "set proxy.a.value=4"));
}

TEST_F(Recording, NeverRemovesAFileItDidNotMake) {
  auto one = setup();
  one.rotation = {std::nullopt, 1min, 0};
  for (const auto* name : {"rec/home-notes.rec", "rec/home-20260101.rec", "rec/home-20260101T000000.000000Z.txt",
                           "rec/homely-20260101T000000.000000Z.rec", "rec/home-20260101T000000.000000Zx.rec"}) {
    disk.put(name, std::string_view("mine"));
  }
  disk.put("rec/home-20250101T000000.000000Z.rec", std::string_view("old"));
  auto recorder = start(one);
  for (int i = 0; i < 5; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(61s);
  }
  EXPECT_EQ(disk.paths().size(), 6u) << testing::PrintToString(disk.paths());
  EXPECT_FALSE(disk.has("rec/home-20250101T000000.000000Z.rec"));
}

TEST_F(Recording, ARotationThatFailsIsToldAndRecordingGoesOn) {
  auto one = setup();
  one.rotation = {std::nullopt, 1min, 3};
  auto recorder = start(one);
  set("proxy.a.value", "1");
  time.run_for(61s);
  disk.put("rec/home-20260101T000000.000000Z.rec", std::string_view("in the way"));
  set("proxy.a.value", "2");
  time.run_for(5s);
  EXPECT_TRUE(disk.has("rec/home-20260101T000000.000000Z-2.rec"));
  set("proxy.a.value", "3");
  time.run_for(5s);
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=3");
  EXPECT_EQ(recorder->counters().dropped, 0u);
}

TEST_F(Recording, WhereNothingCanBeRenamedTheFileGrowsOn) {
  auto one = setup();
  one.rotation = {std::nullopt, 1min, 3};
  auto recorder = start(one);
  set("proxy.a.value", "0");
  time.run_for(2s);
  disk.refuse_renames(true);
  for (int i = 1; i < 200; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(1s);
  }
  EXPECT_LE(recorder->counters().failures, 4u);
  EXPECT_EQ(recorder->counters().dropped, 0u);
  EXPECT_THAT(content().lines, testing::Not(testing::Contains("mark snapshot")));
  recorder.reset();
  EXPECT_EQ(content().sets().size(), 200u);
}

TEST_F(Recording, ASnapshotLargerThanAFileDoesNotRotateForEver) {
  std::uint32_t noise = 1;
  for (int i = 0; i < 300; ++i) {
    std::string value(1000, ' ');
    for (auto& c : value) c = static_cast<char>(33 + ((noise = noise * 1664525 + 1013904223) >> 24) % 90);
    set("proxy.many." + std::to_string(i), value);
  }
  auto one = setup();
  one.rotation = {64 << 10, std::nullopt, 5};
  auto recorder = start(one);
  for (int i = 0; i < 60; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(1100ms);
  }
  EXPECT_LE(recorder->counters().files, 2u);
}

TEST_F(Recording, IsPassiveUnlessItIsToldToBeActive) {
  auto one = setup();
  std::vector<std::string> wanted;
  const auto watch = space.watch_demand({kRecordedIsland, "proxy.**"}, [&](const tuples::Demand& demand) {
    if (demand.wanted) wanted.emplace_back(demand.key);
  });
  auto recorder = start(one);
  set("proxy.a.value", "1");
  EXPECT_THAT(wanted, IsEmpty());
  recorder.reset();
  one.active = true;
  recorder = start(one);
  EXPECT_THAT(wanted, ElementsAre("proxy.a.value"));
}

TEST_F(Recording, WhatTwoPatternsMatchIsWrittenOnce) {
  auto one = setup();
  one.patterns = {*Pattern::parse("proxy.*.value"), *Pattern::parse("proxy.**")};
  auto recorder = start(one);
  set("proxy.a.value", "1");
  set("proxy.b", "2");
  recorder.reset();
  EXPECT_THAT(content().sets(), ElementsAre("set proxy.a.value=1", "set proxy.b=2"));
}

TEST_F(Recording, AMinimumThinsOutAndKeepsTheLatest) {
  auto one = setup();
  one.minimum = 1s;
  auto recorder = start(one);
  for (int i = 0; i < 100; ++i) {
    set("proxy.a.value", std::to_string(i));
    time.run_for(10ms);
  }
  time.run_for(3s);
  EXPECT_LE(content().sets().size(), 3u);
  EXPECT_EQ(content().sets().back(), "set proxy.a.value=99");
}

}  // namespace
}  // namespace rubicon::recorder
