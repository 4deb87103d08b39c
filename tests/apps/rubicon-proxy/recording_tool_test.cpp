#include "apps/rubicon-proxy/recording_tool.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "recording/block_builder.h"
#include "recording/file_format.h"
#include "recording/record.h"
#include "support/memory/memory_transports.h"

namespace rubicon::daemon {
namespace {

using recording::Record;
using recording::RecordKind;
using testing::HasSubstr;

constexpr WallTime kNow{std::chrono::microseconds(1'767'225'600'250'000)};

Record record(RecordKind kind, std::string_view key, std::string_view value) {
  return {kind, kNow, OwnerId(6541), key, value, "text/plain", OwnerId(6541), 7, kNow, {}, {}};
}

class RecordingTool : public testing::Test {
 protected:
  void write(const std::vector<Record>& records) {
    recording::BlockBuilder block;
    auto file = recording::encode_head({OwnerId(6541), "proxy", kNow, "test 1"});
    for (const auto& one : records) block.add(one);
    const auto bytes = block.close();
    file.insert(file.end(), bytes.begin(), bytes.end());
    disk.put("a.rec", file);
  }
  std::string exported(bool jsonl, const std::string& pattern = "") {
    RecordingOptions options;
    options.file = "a.rec";
    options.jsonl = jsonl;
    options.pattern = pattern;
    std::string out;
    done = export_recording(
        disk, options, [&out](std::string_view text) { return out += text, Result<void>(); },
        [this](std::string_view text) { damage += text; });
    return out;
  }
  std::string info() {
    std::string out;
    done = describe_recording(disk, "a.rec", [&out](std::string_view text) { return out += text, Result<void>(); });
    return out;
  }

  transport::MemoryTransports disk;
  Result<void> done;
  std::string damage;
};

TEST_F(RecordingTool, CsvQuotesWhatNeedsItAndWritesBinaryValuesInHex) {
  write({record(RecordKind::kMark, "", "start"), record(RecordKind::kSet, "proxy.a", "21.5"),
         record(RecordKind::kPresent, "proxy.b", "x, \"y\"\nz"), record(RecordKind::kDeleted, "proxy.c", "\xff\x01"),
         record(RecordKind::kSet, "proxy.d", " ü ")});
  EXPECT_EQ(exported(false),
            "seen,event,owner,key,value,encoding,media_type,creator,sequence,write,user,expire\n"
            "1767225600.250000,set,6541,proxy.a,21.5,text,text/plain,6541,7,1767225600.250000,,\n"
            "1767225600.250000,present,6541,proxy.b,\"x, \"\"y\"\"\nz\",text,text/plain,6541,7,1767225600.250000,,\n"
            "1767225600.250000,deleted,6541,proxy.c,ff01,hex,text/plain,6541,7,1767225600.250000,,\n"
            "1767225600.250000,set,6541,proxy.d,\" ü \",text,text/plain,6541,7,1767225600.250000,,\n");
  EXPECT_TRUE(done);
}

TEST_F(RecordingTool, JsonLinesHoldTheSame) {
  write({record(RecordKind::kSet, "proxy.a", "21.5"), record(RecordKind::kSet, "proxy.b", "\xff")});
  EXPECT_EQ(
      exported(true),
      R"({"seen":1767225600.25,"event":"set","owner":6541,"key":"proxy.a","value":"21.5","mimetype":"text/plain",)"
      R"("creator":6541,"seq":7,"write":1767225600.25,"user":0.0,"expire":0.0})"
      "\n"
      R"({"seen":1767225600.25,"event":"set","owner":6541,"key":"proxy.b","value_hex":"ff","mimetype":"text/plain",)"
      R"("creator":6541,"seq":7,"write":1767225600.25,"user":0.0,"expire":0.0})"
      "\n");
}

TEST_F(RecordingTool, APatternChooses) {
  write({record(RecordKind::kSet, "proxy.a", "1"), record(RecordKind::kSet, "robot.b", "2")});
  EXPECT_THAT(exported(true, "robot.**"), testing::Not(HasSubstr("proxy.a")));
  EXPECT_THAT(exported(true, "7:robot.**"), testing::IsEmpty());
  exported(true, "a..b");
  EXPECT_THAT(done.error().text, HasSubstr("--pattern"));
}

TEST_F(RecordingTool, InfoCountsAndNamesDamage) {
  write({record(RecordKind::kSet, "proxy.wsn-1.7.sensor.light-1.value", "1"),
         record(RecordKind::kSet, "proxy.wsn-1.7.sensor.light-1.value", "2"),
         record(RecordKind::kDeleted, "robot.b", "")});
  auto bytes = disk.bytes("a.rec");
  const auto end = bytes.size();
  bytes.resize(end + 7);
  disk.put("a.rec", bytes);
  const auto text = info();
  for (const auto* line :
       {"island: 6541, prefix 'proxy'\n", "written by: 'test 1'\n", "first record: 2026-01-01 00:00:00.250000 UTC\n",
        "blocks: 1 ", "records: 3 (2 set, 1 deleted, 0 expired, 0 present in snapshots)\n", "keys: 2\n",
        "networks: wsn-1\n", "damage: 1 places, 7 bytes\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
  EXPECT_THAT(text, HasSubstr("byte " + std::to_string(end) + ": "));
}

TEST_F(RecordingTool, OtherFilesAreRefused) {
  for (const std::string_view text : {"", "x", "time,temperature\n"}) {
    disk.put("a.rec", text);
    info();
    EXPECT_THAT(done.error().text, HasSubstr("a.rec: is not a recording"));
    EXPECT_THAT(exported(false), testing::IsEmpty());
    EXPECT_EQ(done.error().code, ErrorCode::kInvalid);
  }
}

TEST_F(RecordingTool, AnEmptyRecordingIsATableWithoutLines) {
  constexpr std::string_view kHeader =
      "seen,event,owner,key,value,encoding,media_type,creator,sequence,write,user,expire\n";
  disk.put("a.rec", recording::encode_head({OwnerId(6541), "proxy", kNow, "test 1"}));
  EXPECT_EQ(exported(false), kHeader);
  EXPECT_EQ(exported(true), "");
  EXPECT_TRUE(done);
  EXPECT_THAT(info(), HasSubstr("first record: none\nlast record: none\n"));
  write({record(RecordKind::kMark, "", "start"), record(RecordKind::kSet, "proxy.a", "1")});
  EXPECT_EQ(exported(false, "robot.**"), kHeader);
}

TEST_F(RecordingTool, WhatIsSoundIsExportedAndDamageIsTold) {
  write({record(RecordKind::kSet, "proxy.a", "1")});
  auto bytes = disk.bytes("a.rec");
  const auto block =
      Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(recording::decode_head(bytes).size), bytes.end());
  const auto at = bytes.size();
  bytes.insert(bytes.end(), block.begin(), block.end());
  bytes.back() ^= 1U;
  bytes.insert(bytes.end(), block.begin(), block.end());
  disk.put("a.rec", bytes);
  const auto text = exported(false);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_EQ(damage, "a.rec: byte " + std::to_string(at) + ": the check sum of a block is wrong; " +
                        std::to_string(block.size()) + " bytes skipped");
}

TEST_F(RecordingTool, WhereNothingCanBeWrittenTheWorkEnds) {
  write({record(RecordKind::kSet, "proxy.a", "1"), record(RecordKind::kSet, "proxy.b", "2")});
  RecordingOptions options;
  options.file = "a.rec";
  int calls = 0;
  const auto ended = export_recording(
      disk, options,
      [&calls](std::string_view) -> Result<void> {
        ++calls;
        return fail(ErrorCode::kIo, "the pipe is closed");
      },
      [](std::string_view) {});
  EXPECT_EQ(ended.error().text, "the pipe is closed");
  EXPECT_EQ(calls, 1);
}

/// The subcommand itself, on the disk.
class RecordingCommand : public RecordingTool {
 protected:
  RecordingCommand() {
    std::filesystem::create_directory(folder_);
    write({record(RecordKind::kSet, "proxy.a", "1")});
    const auto& bytes = disk.bytes("a.rec");
    std::ofstream(path("a.rec"), std::ios::binary) << base::as_text(bytes);
    options.file = path("a.rec");
    options.action = "export";
    options.out = path("a.csv");
  }
  ~RecordingCommand() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("rubicon-recording-" + std::to_string(::getpid()));
  RecordingOptions options;
};

TEST_F(RecordingCommand, WritesAFileButNeverOverAnother) {
  EXPECT_EQ(recording(options), 0);
  EXPECT_GT(std::filesystem::file_size(path("a.csv")), 80u);
  EXPECT_EQ(recording(options), 1) << "it is there";
}

TEST_F(RecordingCommand, SaysByItsExitCodeWhoIsToBlame) {
  options.out = path("no folder/a.csv");
  EXPECT_EQ(recording(options), 1);
  options.out = path("b.csv");
  options.pattern = "a..b";
  EXPECT_EQ(recording(options), 2);
  options = {};
  options.file = path("none.rec");
  EXPECT_EQ(recording(options), 2);
  std::ofstream(path("notes.txt")) << "notes";
  options.file = path("notes.txt");
  EXPECT_EQ(recording(options), 2);
}

TEST(RecordingText, TimesBeyondAnyCalendarAreNumbers) {
  EXPECT_EQ(recording::utc_text(WallTime(std::chrono::microseconds(-1))), "-0.000001 s since 1970");
  EXPECT_EQ(recording::utc_text(WallTime::min()).substr(0, 8), "-9223372");
  EXPECT_EQ(recording::utc_text(WallTime::max()).substr(0, 8), "92233720");
}

}  // namespace
}  // namespace rubicon::daemon
