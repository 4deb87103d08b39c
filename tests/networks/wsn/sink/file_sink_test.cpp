#include "networks/wsn/sink/packet_logs.h"

#include <gmock/gmock.h>

#include <fstream>

#include "motes/packet_log.h"
#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using motes::PacketDirection;
using testing::ElementsAre;
using testing::HasSubstr;

class FileSinkTest : public SinkTold {
 protected:
  FileSinkTest() { options.source = parse_source("file@/x.log").value(); }

  void add(std::int64_t milliseconds, std::uint16_t number, PacketDirection direction = PacketDirection::kRead) {
    const auto record = motes::packet_log_record(std::chrono::milliseconds(milliseconds), direction, numbered(number));
    log.insert(log.end(), record->begin(), record->end());
  }
  void play() {
    transports.put("/x.log", log);
    sink = make_sink(options, time, transports, calls());
    ASSERT_TRUE(sink->open());
    started = time.now();
  }
  /// When each packet came, in milliseconds from the first on.
  std::vector<std::int64_t> times() const {
    std::vector<std::int64_t> all;
    for (const auto at : received_at)
      all.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(at - received_at.front()).count());
    return all;
  }

  Bytes log;
  SteadyTime started;
};

TEST_F(FileSinkTest, PlaysWhatTheSinkSaidAtItsPace) {
  add(5000, 1, PacketDirection::kWritten);
  add(8000, 2);
  add(8100, 3, PacketDirection::kWritten);
  add(8965, 4);
  add(8966, 5);
  play();
  EXPECT_EQ(phase(), Phase::kConnecting);
  time.run_ready();
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_THAT(received, ElementsAre(numbered(2))) << "nothing is waited for first";
  time.run_for(10s);
  EXPECT_THAT(received, ElementsAre(numbered(2), numbered(4), numbered(5)));
  EXPECT_THAT(times(), ElementsAre(0, 965, 966));
  EXPECT_EQ(phase(), Phase::kEnded);
  EXPECT_EQ(states.size(), 2U);
  EXPECT_EQ(count("packets-read"), 3U);
}

TEST_F(FileSinkTest, TakesAClockSetBackForNoPauseAndNoPauseForLongerThanAnHour) {
  add(1'000'000'000, 1);
  add(500'000'000, 2);
  add(500'000'100, 3);
  add(900'000'000, 4);
  add(std::numeric_limits<std::int64_t>::max(), 5);
  add(std::numeric_limits<std::int64_t>::min(), 6);
  add(std::numeric_limits<std::int64_t>::max(), 7);
  play();
  time.run_for(4h);
  EXPECT_THAT(times(), ElementsAre(0, 0, 100, 3'600'100, 7'200'100, 7'200'100, 10'800'100));
}

TEST_F(FileSinkTest, PassesOverDamageAndSaysWhere) {
  add(0, 1);
  log.insert(log.end(), 100, 0xee);
  add(1000, 2);
  log.insert(log.end(), {0, 0, 1});
  play();
  time.run_for(10s);
  EXPECT_THAT(received, ElementsAre(numbered(1), numbered(2)));
  EXPECT_EQ(count("damaged"), 2U);
  EXPECT_EQ(count("skipped-bytes"), 103U);
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_EQ(notes[0].first, "damaged");
  EXPECT_THAT(notes[0].second, HasSubstr("/x.log: offset 25"));
  EXPECT_EQ(phase(), Phase::kEnded);
}

TEST_F(FileSinkTest, EndsAtOnceWithAnEmptyFile) {
  play();
  time.run_ready();
  EXPECT_EQ(phase(), Phase::kEnded);
  EXPECT_EQ(sink->state().reason, "the recording has ended");
  EXPECT_TRUE(sink->open());
  time.run_for(1h);
  EXPECT_EQ(states.size(), 2U);
}

TEST_F(FileSinkTest, PlaysTenThousandRecordsOfOneMoment) {
  for (std::uint16_t i = 0; i < 10000; ++i) add(7, i);
  play();
  time.run_for(1ms);
  ASSERT_EQ(received.size(), 10000U);
  EXPECT_EQ(received.back(), numbered(9999));
}

TEST_F(FileSinkTest, RefusesCommands) {
  play();
  const auto sent = send(1);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kRefused);
  EXPECT_EQ(sent.error().text, "a recording takes no packets: recorded motes cannot be commanded");
  time.run_for(1s);
  EXPECT_FALSE(outcome(1));
}

TEST_F(FileSinkTest, SaysThatThereIsNoFile) {
  sink = make_sink(options, time, transports, calls());
  const auto opened = sink->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(phase(), Phase::kOff);
}

TEST_F(FileSinkTest, GoesOnWhereReadingFailed) {
  for (std::uint16_t i = 0; i < 1000; ++i) add(std::int64_t{i} * 10, i);
  reopens = false;
  play();
  transports.fail_at("/x.log", 10000);
  time.run_for(60s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(phase(), Phase::kOff);
  const auto before = received.size();
  EXPECT_LT(before, 1000U);
  transports.put("/x.log", log);
  ASSERT_TRUE(sink->open());
  time.run_ready();
  EXPECT_LT(received.size(), before + 3) << "nothing is made up for";
  time.run_for(60s);
  ASSERT_EQ(received.size(), 1000U);
  for (std::uint16_t i = 0; i < 1000; ++i) ASSERT_EQ(received[i], numbered(i));
  EXPECT_EQ(count("damaged"), 0U);
}

TEST_F(FileSinkTest, MayBeDestroyedInItsCalls) {
  add(0, 1);
  add(0, 2);
  on_received = [&] { sink.reset(); };
  play();
  time.run_for(1s);
  EXPECT_EQ(sink, nullptr);
  EXPECT_EQ(received.size(), 1U);
}

/// log.md 1.1 and 1.2: 37 read records in 32.980 s.
TEST_F(FileSinkTest, PlaysTheOriginalsRecording) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/log/two_motes.bin", std::ios::binary);
  ASSERT_TRUE(file);
  log.assign(std::istreambuf_iterator<char>(file), {});
  play();
  time.run_for(1min);
  ASSERT_EQ(received.size(), 37U);
  EXPECT_EQ(times()[1], 7946);
  EXPECT_EQ(times().back(), 32980);
  EXPECT_EQ(count("damaged"), 0U);
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
