#include <gmock/gmock.h>

#include <filesystem>

#include "island/virtual_island.h"
#include "recording/recording_reader.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using tuples::Verdict;

constexpr const char* kHallToRecord = "{hall: {sensors: {temperature-1: {wave: constant, value: 21}}}}";
constexpr const char* kTwoRecorders =
    "recorders:\n  all: {file: all.rec, patterns: [\"proxy.**\"]}\n  some: {file: some.rec, patterns: [\"proxy.*\"]}\n";

class RecordersOfAnIsland : public testing::Test {
 protected:
  RecordersOfAnIsland() {
    statuses = space.subscribe({kHome, "proxy.recorder.*.*"}, {.passive = true}, [](const tuples::Event&) {});
    time.run_for(3s);
  }
  tuples::Reply command(std::string_view text, const std::string& name = "all") {
    tuples::Reply got;
    space.set_remote(kHome, "proxy.recorder." + name + ".command", text, 5s,
                     [&](const tuples::Reply& reply) { got = reply; });
    time.run_for(10ms);
    return got;
  }
  json status(const std::string& name = "all") {
    const auto tuple = space.get(kHome, "proxy.recorder." + name + ".status");
    return tuple ? json::parse(tuple->value) : json();
  }
  /// All marks of the file, in order.
  std::vector<std::string> marks() {
    std::vector<std::string> words;
    recording::RecordingReader reader;
    const auto bytes = home.files.bytes("all.rec");
    reader.feed(bytes);
    reader.end();
    while (auto item = reader.next()) {
      const auto* record = std::get_if<recording::Record>(&*item);
      if (record && record->kind == recording::RecordKind::kMark) words.emplace_back(record->value);
    }
    return words;
  }

  static constexpr OwnerId kHome{6541};
  base::NullLogSink quiet;
  VirtualScheduler clock;
  LogLines lines{quiet, clock};
  VirtualIsland home{kHallToRecord, kTwoRecorders};
  VirtualScheduler& time = home.time;
  TupleSpace& space = *home.space;
  tuples::Handle statuses;
};

TEST_F(RecordersOfAnIsland, ShowWhatTheyDo) {
  EXPECT_EQ(status()["state"], "recording");
  EXPECT_EQ(status()["file"], (std::filesystem::current_path() / "all.rec").string())
      << "other programs are in other folders";
  EXPECT_GT(status()["records"].get<int>(), 0);
  EXPECT_GT(status()["size"].get<int>(), 0);
  EXPECT_EQ(status()["dropped"], 0);
  EXPECT_GT(status()["since"].get<double>(), 0);
  EXPECT_EQ(status("some")["file"], (std::filesystem::current_path() / "some.rec").string());
}

TEST_F(RecordersOfAnIsland, AStoppedOneWritesNothingUntilItIsStarted) {
  EXPECT_EQ(command("stop").verdict, Verdict::kApplied);
  EXPECT_EQ(status()["state"], "stopped");
  EXPECT_EQ(status()["command"]["state"], "confirmed");
  const auto records = status()["records"].get<int>();
  const auto size = home.files.bytes("all.rec").size();
  EXPECT_EQ(status()["size"], size);
  time.run_for(1min);
  EXPECT_EQ(home.files.bytes("all.rec").size(), size);
  EXPECT_EQ(home.space->get(kHome, "proxy.recorder.some.status").has_value(), true);
  EXPECT_EQ(status("some")["state"], "recording");
  EXPECT_EQ(command("start").verdict, Verdict::kApplied);
  time.run_for(3s);
  EXPECT_EQ(status()["state"], "recording");
  EXPECT_GT(home.files.bytes("all.rec").size(), size);
  EXPECT_GT(status()["records"].get<int>(), records) << "the counters go on";
  EXPECT_THAT(marks(), testing::ElementsAre("start", "complete", "start", "complete"));
}

TEST_F(RecordersOfAnIsland, AMarkStandsInTheFile) {
  EXPECT_EQ(command("mark").verdict, Verdict::kApplied);
  EXPECT_EQ(command("mark lamp changed").verdict, Verdict::kApplied);
  time.run_for(2s);
  EXPECT_THAT(marks(), testing::ElementsAre("start", "complete", "mark", "mark: lamp changed"));
  command("mark " + std::string(201, 'x'));
  EXPECT_EQ(status()["command"]["state"], "refused");
  command("mark a\nb");
  EXPECT_EQ(status()["command"]["state"], "refused");
  command("stop");
  command("mark late");
  EXPECT_EQ(status()["command"]["state"], "refused");
  EXPECT_EQ(status()["command"]["reason"], "recorder all is stopped");
}

TEST_F(RecordersOfAnIsland, OtherWordsAreRefusedAtOnce) {
  for (const auto* text : {"", "Stop", "pause", "markx", "start now"}) {
    const auto reply = command(text);
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << text;
    EXPECT_THAT(reply.text, HasSubstr("expected `start`, `stop` or `mark TEXT`"));
  }
  EXPECT_EQ(status()["state"], "recording");
  EXPECT_NE(command("stop", "none").verdict, Verdict::kApplied);
}

TEST_F(RecordersOfAnIsland, AFullDiskIsShownAndAStartThatFailsSaysWhy) {
  command("stop");
  home.files.room(0);
  command("start");
  EXPECT_EQ(status()["state"], "dropping");
  EXPECT_EQ(status()["command"]["state"], "failed") << status();
  EXPECT_THAT(status()["reason"].get<std::string>(), testing::Not(IsEmpty()));
  home.files.room(std::nullopt);
  time.run_for(2min);
  EXPECT_EQ(status()["state"], "recording");
  EXPECT_GT(status()["failures"].get<int>(), 0);
}

TEST_F(RecordersOfAnIsland, TheLinesOfTheLogAreNotRecorded) {
  home.island->show_log(lines);
  time.run_for(1s);
  base::Log(lines, "test").info("not recorded");
  time.run_for(3s);
  recording::RecordingReader reader;
  const auto bytes = home.files.bytes("all.rec");
  reader.feed(bytes);
  reader.end();
  std::vector<std::string> keys;
  while (auto item = reader.next()) {
    if (const auto* record = std::get_if<recording::Record>(&*item)) keys.emplace_back(record->key);
  }
  EXPECT_THAT(keys, testing::Not(Contains("proxy.log.lines")));
  EXPECT_THAT(keys, Contains("proxy.settings.value"));
}

}  // namespace
}  // namespace rubicon::island
