#include <gmock/gmock.h>

#include "networks/log/log_support.h"

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
  EXPECT_TRUE(listener_.of<model::Join>().empty()) << "open() delivers nothing";
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
    capture_ = bytes_of_file(RUBICON_SOURCE_DIR "/tests/cases/log/two_motes.bin");
    ASSERT_FALSE(capture_.empty());
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

}  // namespace
}  // namespace rubicon::networks::log
