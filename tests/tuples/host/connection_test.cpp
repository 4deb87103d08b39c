#include "tuples/host/connection.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"

namespace rubicon::tuples::host {
namespace {

using testing::ElementsAre;

/// Takes all that is written, each call as one text.
struct Sink final : transport::LocalStream {
  explicit Sink(std::vector<Bytes>& all) : writes(all) {}
  Result<std::size_t> write(ByteView bytes) override {
    writes.emplace_back(bytes.begin(), bytes.end());
    return bytes.size();
  }
  std::size_t unread() const override { return 0; }
  const transport::LocalPeer& peer() const override { return who; }

  std::vector<Bytes>& writes;
  transport::LocalPeer who;
};

struct ConnectionOfAProcess : testing::Test {
  ConnectionOfAProcess() { connection.take(std::make_unique<Sink>(writes)); }

  static Record frame(std::uint32_t target, std::string_view entries, std::uint64_t start = 1) {
    return {Record::Type::kFrame, OwnerId(6541), OwnerId(target), start, {}, base::as_bytes(entries)};
  }
  /// The records of a write: `target:entries`.
  static std::vector<std::string> records_of(ByteView bytes) {
    std::vector<std::string> all;
    while (bytes.size() >= kSizeBytes) {
      const auto size = bytes[0] | std::size_t{bytes[1]} << 8;
      const auto record = read_record(bytes.subspan(kSizeBytes, size));
      EXPECT_TRUE(record);
      all.push_back(std::to_string(number(record->target)) + ":" + std::string(base::as_text(record->content)));
      bytes = bytes.subspan(kSizeBytes + size);
    }
    EXPECT_TRUE(bytes.empty());
    return all;
  }

  VirtualScheduler time;
  std::vector<Bytes> writes;
  Connection connection{time};
  transport::LocalCallbacks calls =
      connection.begin({[this](const Record&) { connection.send(frame(7, "answer")); }, {}});
};

TEST_F(ConnectionOfAProcess, WritesTheFramesOfATurnAtOnceAndThoseOfOneWayAsOne) {
  connection.send(frame(1, "a"));
  connection.send(frame(1, "b"));
  connection.send(frame(2, "c"));
  connection.send(frame(1, "d"));
  connection.send(frame(1, "later start", 2));
  connection.send({Record::Type::kReady});
  connection.send({Record::Type::kReady});
  EXPECT_TRUE(writes.empty());
  time.run_ready();
  ASSERT_EQ(writes.size(), 1U);
  EXPECT_THAT(records_of(writes[0]), ElementsAre("1:ab", "2:c", "1:d", "1:later start", "0:", "0:"));
  connection.send(frame(1, "e"));
  time.run_ready();
  ASSERT_EQ(writes.size(), 2U);
  EXPECT_THAT(records_of(writes[1]), ElementsAre("1:e")) << "the frame before was written already";
}

TEST_F(ConnectionOfAProcess, AFrameGrowsToItsBoundOnly) {
  const std::string half(Connection::kFrameBytes / 2, 'x');
  for (int i = 0; i < 3; ++i) connection.send(frame(1, half));
  time.run_ready();
  std::vector<std::size_t> sizes;
  for (const auto& record : records_of(writes[0])) sizes.push_back(record.size());
  EXPECT_THAT(sizes, ElementsAre(half.size() + 2, half.size() + 2, half.size() + 2)) << "with its header it is longer";
}

TEST_F(ConnectionOfAProcess, AnswersGoBeforeMoreIsRead) {
  Bytes question;
  append(question, frame(1, "?"));
  append(question, frame(1, "?"));
  const ByteView bytes(question);
  calls.received(bytes.first(bytes.size() - 1));
  ASSERT_EQ(writes.size(), 1U);
  EXPECT_THAT(records_of(writes[0]), ElementsAre("7:answer"));
  calls.received(bytes.last(1));
  ASSERT_EQ(writes.size(), 2U);
  time.run_ready();
  EXPECT_EQ(writes.size(), 2U);
}

}  // namespace
}  // namespace rubicon::tuples::host
