#include "history/import.h"

#include <gtest/gtest.h>

#include <fstream>

#include "history/history_source.h"
#include "history/history_support.h"
#include "history/message_questions.h"
#include "recording/block_builder.h"
#include "recording/file_format.h"
#include "transport/local_transports.h"

namespace rubicon::history {
namespace {

using recording::Record;
using recording::RecordKind;

const std::string kLamp = "proxy.dummy.hall.sensor.light-1";

/// Writes a recording of one point that has a value each second, and is stale for a while.
class ImportTest : public testing::Test {
 protected:
  ImportTest() {
    const auto head = recording::encode_head({OwnerId(6541), "proxy", wall(kBegin), "test"});
    bytes_.assign(head.begin(), head.end());
    add(0, kLamp + ".description", R"({"data_type":"real","unit":"lx"})");
    add(0, kLamp + ".status", R"({"quality":"good"})");
    for (int i = 0; i < 60; ++i) add(i, kLamp + ".value", std::to_string(i));
    add(60, kLamp + ".status", R"({"quality":"stale"})");
    add(90, kLamp + ".status", R"({"quality":"good"})");
    add(90, kLamp + ".value", "7");
    add(91, "proxy.dummy.hall.status", "{}");
    const auto block = builder_.close();
    bytes_.insert(bytes_.end(), block.begin(), block.end());
    std::ofstream(folder_ / "r.rec", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
  }
  void add(int second, const std::string& key, const std::string& value) {
    Record record;
    record.seen = record.write_time = wall(kBegin + second * kSecond);
    record.owner = record.creator = OwnerId(6541);
    record.key = key;
    record.value = value;
    record.media_type = "text/plain";
    record.sequence = 1;
    ASSERT_TRUE(builder_.add(record));
  }
  Result<Imported> import(const ImportRules& rules) {
    return import_recording(*store_, files_, folder_ / "r.rec", rules);
  }

  Folder folder_;
  recording::BlockBuilder builder_;
  Bytes bytes_;
  transport::LocalTransports files_;
  std::unique_ptr<Store> store_ = opened(folder_ / "h");
};

TEST_F(ImportTest, TakesTheValuesOfPoints) {
  const auto done = import({});
  ASSERT_TRUE(done) << done.error().text;
  EXPECT_EQ(done->records, 66U);
  const auto points = points_of(*store_, kLamp + ".value");
  ASSERT_GE(points.size(), 62U);
  EXPECT_EQ(points.front(), (Point{kBegin, 0}));
  EXPECT_EQ(points[60], (Point{kBegin + 60 * kSecond, kGap}));
  EXPECT_EQ(points.back(), (Point{kBegin + 90 * kSecond, 7}));
  EXPECT_EQ(store_->series().size(), 1U);
  EXPECT_EQ(store_->series().begin()->second.declaration.unit, "lx");
}

TEST_F(ImportTest, MovesAllTimesToItsEnd) {
  ImportRules rules;
  rules.end = wall(kBegin + 100 * kDay);
  ASSERT_TRUE(import(rules));
  const auto points = points_of(*store_, kLamp + ".value");
  EXPECT_EQ(points.front().time, kBegin + 100 * kDay - 91 * kSecond);
  EXPECT_EQ(points.back().time, kBegin + 100 * kDay - kSecond);
}

TEST_F(ImportTest, LeavesOutWhatIsExcluded) {
  ImportRules rules;
  rules.exclude = {*Pattern::parse("*:*.*.*.sensor.light-1.value")};
  ASSERT_TRUE(import(rules));
  EXPECT_TRUE(store_->series().empty());
}

TEST_F(ImportTest, RefusesWhatIsNoRecording) {
  std::ofstream(folder_ / "r.rec") << "no recording";
  EXPECT_EQ(import({}).error().code, ErrorCode::kInvalid);
  std::filesystem::remove(folder_ / "r.rec");
  EXPECT_FALSE(import({}));
}

TEST_F(ImportTest, AnswersAsJsonAndCsv) {
  ASSERT_TRUE(import({}));
  const auto got = answer(*store_, {{{OwnerId(6541), kLamp + ".value"}}, wall(kBegin), wall(kBegin + 2 * kMinute), 2});
  ASSERT_TRUE(got);
  EXPECT_EQ(to_json(*got), "{\"from\":1767225600,\"to\":1767225720,\"bucket\":60,\"series\":[{\"key\":\"6541:" + kLamp +
                               ".value\",\"kind\":\"number\",\"unit\":\"lx\",\"t\":[1767225600,1767225660],\"first\":["
                               "0,59],\"min\":[0,7],\"max\":[59,59],"
                               "\"mean\":[29.5,7],\"last\":[59,7],\"n\":[60,2],\"gaps\":[]}]}");
  EXPECT_EQ(to_csv(*got), "time,key,count,first,minimum,maximum,mean,last\n1767225600,6541:" + kLamp +
                              ".value,60,0,0,59,29.5,59\n1767225660,6541:" + kLamp + ".value,2,59,7,59,7,7\n");
  for (const std::size_t buckets : {2U, 1000U}) {
    const auto one =
        answer(*store_, {{{OwnerId(6541), kLamp + ".value"}}, wall(kBegin), wall(kBegin + 2 * kMinute), buckets});
    const auto read = answer_from_json(to_json(one.value()));
    ASSERT_TRUE(read);
    EXPECT_EQ(to_csv(*read), to_csv(*one));
    EXPECT_EQ(read->bucket, one->bucket);
  }
  for (const auto* text : {"", "[]", "{}", R"({"series":[{}]})", R"({"series":[{"key":"1:a","kind":"odd"}]})"})
    EXPECT_FALSE(answer_from_json(text)) << text;
}

}  // namespace
}  // namespace rubicon::history
