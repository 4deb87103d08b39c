#include <gmock/gmock.h>

#include "log_support.h"
#include "networks/log/packet_log_reader.h"

namespace rubicon::networks::log {
namespace {

using testing::HasSubstr;

// Vector log-file-3rec: written SET_ISLAND_ID, read join of mote 5, read updates of mote 5 (log.md 1.1).
std::string three_records() {
  const std::string zeros91(182, '0'), zeros86(172, '0');
  const auto bytes = base::from_hex(
      "000001a1fb6476da000000000b 00000100000300250a7d7e"
      "000001a1fb647945010000007a 00ffff000172221c 000bfffd000b0005000000 66 030a 10000b000501004301" +
      zeros91 +
      "000001a1fb647b9a010000007a 00ffff000172221c 000bfffd000b0005001234 66 030a 23030001012c00021964004004b0" +
      zeros86);
  return std::string(base::as_text(*bytes));
}

/// Three joins (motes 1 to 3) at the given times in milliseconds.
std::string joins_at(std::initializer_list<std::int64_t> times) {
  std::string out;
  std::uint8_t mote = 0;
  for (const std::int64_t time : times) {
    base::ByteWriter record;
    const auto packet = base::from_hex("00ffff000017 001c 000bfffd000b0000000000 66 030a 10000b0000 01004301");
    Bytes bytes = *packet;
    bytes[5] = static_cast<std::uint8_t>(bytes.size() - 8);
    bytes[15] = bytes[26] = ++mote;
    record.u64_be(static_cast<std::uint64_t>(time)).u8(1).u32_be(static_cast<std::uint32_t>(bytes.size())).bytes(bytes);
    out += base::as_text(record.view());
  }
  return out;
}

struct Read {
  std::vector<PacketRecord> records;
  std::vector<Damage> damages;
};

Read read_all(std::string_view content, std::size_t piece = 64 * 1024) {
  PacketLogReader reader;
  Read out;
  const auto drain = [&] {
    while (auto item = reader.next()) {
      if (auto* record = std::get_if<PacketRecord>(&*item))
        out.records.push_back(std::move(*record));
      else
        out.damages.push_back(std::get<Damage>(*item));
    }
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    reader.feed(base::as_bytes(content.substr(at, piece)));
    drain();
  }
  reader.end();
  drain();
  return out;
}

TEST(PacketLog, ReadsRecordsWithTimeDirectionAndPacket) {
  const Read read = read_all(three_records());
  ASSERT_EQ(read.records.size(), 3u);
  EXPECT_TRUE(read.damages.empty());
  EXPECT_EQ(read.records[0].offset, 0u);
  EXPECT_FALSE(read.records[0].from_sink);
  EXPECT_EQ(read.records[1].offset, 24u);
  EXPECT_EQ(read.records[1].time.count(), 0x01a1fb647945);
  EXPECT_TRUE(read.records[1].from_sink);
  EXPECT_EQ(read.records[2].offset, 159u);
  EXPECT_EQ(read.records[2].packet.size(), 122u);
}

TEST(PacketLog, IsTheSameInPiecesOfAnySize) {
  for (const std::size_t piece : {1u, 2u, 7u, 13u, 134u, 135u}) {
    const Read read = read_all(three_records(), piece);
    EXPECT_EQ(read.records.size(), 3u) << piece;
    EXPECT_TRUE(read.damages.empty()) << piece;
  }
}

TEST(PacketLog, EveryTruncationGivesTheWholeRecordsBeforeIt) {
  const std::string whole = three_records();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Read read = read_all(std::string_view(whole).substr(0, length));
    const std::size_t expected = length < 24 ? 0u : length < 159 ? 1u : 2u;
    EXPECT_EQ(read.records.size(), expected) << length;
    const bool between_records = length == 0 || length == 24 || length == 159;
    ASSERT_EQ(read.damages.size(), between_records ? 0u : 1u) << length;
    if (between_records) continue;
    EXPECT_THAT(read.damages[0].why, HasSubstr("cut short by the end of the file"));
  }
}

TEST(PacketLog, ADamagedRecordIsReportedAndTheNextSoundOneFound) {
  struct Change {
    std::size_t at;
    std::uint8_t value;
    const char* why;
  };
  for (const Change& change : {Change{24 + 8, 2, "direction 2, expected 0 or 1"},
                               Change{24 + 9, 0xff, "packet length -16777094, expected 8 to 255"},
                               Change{24 + 12, 0, "packet length 0, expected 8 to 255"},
                               Change{24 + 12, 0x7b, "dispatch byte 00 and AM length 114 in a packet of 123 bytes"},
                               Change{24 + 13, 7, "dispatch byte 07 and AM length 114 in a packet of 122 bytes"}}) {
    std::string content = three_records();
    content[change.at] = static_cast<char>(change.value);
    const Read read = read_all(content);
    ASSERT_EQ(read.records.size(), 2u) << change.why;
    EXPECT_EQ(read.records[1].offset, 159u);
    ASSERT_EQ(read.damages.size(), 1u) << change.why;
    EXPECT_EQ(read.damages[0].offset, 24u);
    EXPECT_EQ(read.damages[0].bytes, 135u);
    EXPECT_EQ(read.damages[0].why, change.why);
  }
}

TEST(PacketLog, GarbageBeforeAndBetweenRecordsIsSkipped) {
  const std::string whole = three_records();
  const Read read = read_all("hello" + whole.substr(0, 24) + std::string(1000, '\x01') + whole.substr(24));
  EXPECT_EQ(read.records.size(), 3u);
  ASSERT_EQ(read.damages.size(), 2u);
  EXPECT_EQ(read.damages[0].bytes, 5u);
  EXPECT_EQ(read.damages[1].offset, 29u);
  EXPECT_EQ(read.damages[1].bytes, 1000u);
}

class LogPackets : public testing::Test {
 protected:
  void open(std::vector<std::pair<std::string, ConfigNode>> options, const std::string& content) {
    listener_.files.files["capture.bin"] = content;
    options.insert(options.begin(), {"file", scalar("capture.bin")});
    made_ = make_log(listener_, map(std::move(options)), types_);
    ASSERT_NE(made_.network, nullptr) << (made_.errors.empty() ? "" : made_.errors.front());
    ASSERT_TRUE(made_.network->open().has_value());
  }

  TypeCatalogue types_;
  Listener listener_;
  Made made_;
};

TEST_F(LogPackets, PlaysWhatTheSinkReadInPhysicalUnitsAndAtTheRecordedPace) {
  open({}, three_records());
  EXPECT_TRUE(listener_.of<model::Join>().empty()) << "nothing is told from inside open()";
  listener_.time.run_for(1s);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 1u);
  EXPECT_EQ(joins[0].second.source.device, "5");
  const auto updates = listener_.of<model::Updates>();
  ASSERT_EQ(updates.size(), 1u);
  EXPECT_EQ(updates[0].first - joins[0].first, 597ms);
  const auto readings = listener_.readings();
  ASSERT_EQ(readings.size(), 3u);
  EXPECT_EQ(readings[0].point.type, types_.find("light")->id);
  EXPECT_EQ(model::to_text(readings[0].value), "686.6");
  EXPECT_EQ(model::to_text(readings[1].value), "25.4");
  EXPECT_EQ(readings[0].user_time, WallTime(std::chrono::milliseconds(0x01a1fb647b9a)));
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
  EXPECT_EQ(listener_.counter("records"), 2u);
  EXPECT_EQ(listener_.counter("readings"), 3u);
}

TEST_F(LogPackets, UserTimeIsTheTimeOfReplayOnRequest) {
  open({{"times", scalar("replay")}}, three_records());
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.readings().at(0).user_time,
            WallTime(std::chrono::sys_days(std::chrono::year(2026) / 1 / 1)) + 597ms);
}

TEST_F(LogPackets, TimeThatStepsBackIsNoPauseAndLoggedOnce) {
  open({}, joins_at({10'000, 5'000, 2'000, 3'000}));
  listener_.time.run_for(10s);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 4u);
  EXPECT_EQ(joins[2].first, joins[0].first);
  EXPECT_EQ(joins[3].first - joins[0].first, 1s);
  EXPECT_EQ(listener_.lines.size(), 1u);
}

TEST_F(LogPackets, AHugeGapIsCutToTheLongestPermitted) {
  open({{"longest-gap", scalar("2s")}}, joins_at({0, 86'400'000, 86'401'000}));
  listener_.time.run_for(3s);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 3u);
  EXPECT_EQ(joins[1].first, 2s);
  EXPECT_EQ(joins[2].first, 3s);
}

TEST_F(LogPackets, TimesAtTheEndsOfTheCalendarAreSurvived) {
  open({{"speed", scalar("max")}},
       joins_at({std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(), -1, 0}));
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.of<model::Join>().size(), 4u);
}

TEST_F(LogPackets, TheStartOffsetPassesOverReadingsButNotJoins) {
  open({{"start", scalar("1h")}}, three_records());
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.of<model::Join>().size(), 1u);
  EXPECT_TRUE(listener_.of<model::Updates>().empty());
}

TEST_F(LogPackets, DamageIsCountedAndLoggedWithFileAndPosition) {
  open({{"speed", scalar("max")}}, "x" + three_records() + "y" + three_records());
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.counter("damaged"), 2u);
  EXPECT_EQ(listener_.counter("skipped-bytes"), 2u);
  EXPECT_EQ(listener_.counter("records"), 4u);
  ASSERT_FALSE(listener_.lines.empty());
  EXPECT_THAT(listener_.lines[0], HasSubstr("capture.bin: byte 0: "));
  EXPECT_EQ(std::count_if(listener_.lines.begin(), listener_.lines.end(),
                          [](const std::string& line) { return line.find("byte ") != std::string::npos; }),
            1)
      << "once a minute";
}

TEST_F(LogPackets, AFileOfGarbageEndsWithoutStoppingAnything) {
  open({{"speed", scalar("max")}, {"loop", scalar("yes")}}, std::string(5'000'000, '\x01'));
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
  EXPECT_EQ(listener_.counter("skipped-bytes"), 5'000'000u);
}

/// The capture of the original recorder (log.md 1.1 and 2.3).
class LogCapture : public LogPackets {
 protected:
  void SetUp() override {
    capture_ = bytes_of_file(shared_data("motes/origjava_log_pkt.bin"));
    if (capture_.empty()) GTEST_SKIP() << "no ../shared/data/motes/origjava_log_pkt.bin beside the source tree";
  }

  std::string capture_;
};

TEST_F(LogCapture, Plays37MessagesJoinsFirst) {
  open({}, capture_);
  listener_.time.run_for(1min);
  EXPECT_EQ(listener_.counter("records"), 37u);
  EXPECT_EQ(listener_.counter("damaged"), 0u);
  EXPECT_EQ(listener_.of<model::Updates>().size(), 33u);
  EXPECT_EQ(listener_.of<model::KeepAlive>().size(), 2u);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 4u) << "two joins, and each mote again with the sensors it showed";
  EXPECT_EQ(joins[0].second.source.device, "2");
  EXPECT_EQ(joins[1].second.source.device, "3");
  EXPECT_EQ(joins[1].first - joins[0].first, 7946ms);
  EXPECT_LT(joins[1].first, listener_.of<model::Updates>().front().first);
  EXPECT_EQ(listener_.of<model::State>().back().first, 32980ms);
}

TEST_F(LogCapture, TakesATenthOfTheTimeAtSpeedTen) {
  open({{"speed", scalar("10")}}, capture_);
  listener_.time.run_for(3297ms);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kUp);
  listener_.time.run_for(2ms);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
}

TEST_F(LogCapture, EveryTruncationIsSurvived) {
  for (std::size_t length = 0; length < capture_.size(); length += 1) {
    const Read read = read_all(std::string_view(capture_).substr(0, length));
    EXPECT_EQ(read.records.size(), length < 24 ? 0 : 1 + (length - 24) / 135) << length;
    EXPECT_LE(read.damages.size(), 1u) << length;
  }
}

TEST_F(LogCapture, EverySingleByteCorruptionCostsAtMostItsRecord) {
  for (std::size_t at = 0; at < capture_.size(); ++at) {
    std::string damaged = capture_;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    EXPECT_GE(read_all(damaged).records.size(), 40u) << at;
  }
}

}  // namespace
}  // namespace rubicon::networks::log
