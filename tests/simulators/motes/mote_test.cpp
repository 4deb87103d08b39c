#include <gmock/gmock.h>

#include "simulators/motes/simulated_sink.h"

namespace rubicon::motes_simulator {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// What motes do with commands (wsn.md 9.3 to 9.6).
class SimulatedMote : public SimulatedSink {
 protected:
  void send_command(std::uint16_t mote, std::string_view record, std::uint16_t sequence = 0x1234,
                    std::uint8_t reliable = 0, std::uint8_t application = 5) {
    const auto bytes = hex(record);
    send(++serial_, command(mote, bytes, sequence, reliable, application));
    time.run_for(100ms);
  }
  std::vector<motes::RawUpdates> updates(std::uint16_t mote) const {
    std::vector<motes::RawUpdates> all;
    for (const auto& one : packets(mote)) {
      const auto record = motes::decode_record(one.net());
      if (record && std::holds_alternative<motes::RawUpdates>(*record))
        all.push_back(std::get<motes::RawUpdates>(*record));
    }
    return all;
  }
  std::uint8_t serial_ = 0;
};

TEST_F(SimulatedMote, ReportsEachPeriodInTinyOsMilliseconds) {
  joined();
  const auto begin = time.now();
  send_command(2, "01 0043 03e8");
  time.run_for(5s);
  EXPECT_THAT(lights(2), ElementsAre(300, 307, 314, 321, 328));  // each 977 ms
  const auto all = packets(2);
  const std::chrono::duration<double> period = all[3].at - all[2].at;
  EXPECT_NEAR(period.count(), 1000 / 1024.0, 0.02);
  EXPECT_GT(all[0].at - begin, 1000ms);  // 1097 and 1080 ms in the original's log
  EXPECT_LT(all[0].at - begin, 1100ms);
  EXPECT_THAT(all, SizeIs(5));
  for (const auto& one : all) {
    EXPECT_EQ(one.packet.size(), 122u);
    EXPECT_EQ(one.packet[5], 0x72) << "AM length";
    EXPECT_EQ(one.net().counted, kFullCount);
  }
}

/// Motes whose sensors need the time of an SHT11.
class SlowSensors : public SimulatedMote {
 protected:
  void SetUp() override {
    auto options = plain();
    for (auto& place : options.motes) place.mote.sensor_time = 210ms;
    joined(std::move(options));
  }
  std::vector<int> temperatures() const {
    std::vector<int> all;
    for (const auto& one : packets(2, motes::kTransportConnectionless))
      all.push_back(std::get<motes::DemoReport>(motes::decode_record(one.net()).value()).temperature);
    return all;
  }
};

TEST_F(SlowSensors, AReportCarriesWhatTheTickBeforeMeasuredAndTheFirstOneNothing) {
  send_command(2, "01 0003 0400");
  time.run_for(4500ms);
  EXPECT_THAT(lights(2), ElementsAre(0, 300, 307, 314));
  EXPECT_THAT(temperatures(), ElementsAre(0, 6500, 6501, 6502));
}

TEST_F(SlowSensors, ASensorThatIsAddedHasNothingInTheFirstReportAndTheOthersGoOn) {
  send_command(2, "01 0001 0400");
  time.run_for(2500ms);
  came.clear();
  send_command(2, "01 0003 0400");
  time.run_for(3s);
  EXPECT_THAT(lights(2), ElementsAre(307, 314, 321));
  EXPECT_THAT(temperatures(), ElementsAre(0, 6500, 6501));
}

TEST_F(SlowSensors, AfterAPauseTheFirstReportCarriesTheLastValueOfBefore) {
  send_command(2, "01 0001 0400");
  time.run_for(3500ms);
  send_command(2, "01 0000 ffff");
  time.run_for(1min);
  came.clear();
  send_command(2, "01 0001 0400");
  time.run_for(2500ms);
  EXPECT_THAT(lights(2), ElementsAre(314, 321));
}

TEST_F(SlowSensors, AfterARebootTheFirstReportCarriesZero) {
  send_command(2, "01 0001 0400");
  time.run_for(3500ms);
  world->mote(2).boot();
  time.run_for(1s);
  came.clear();
  send_command(2, "01 0001 0400");
  time.run_for(2500ms);
  EXPECT_THAT(lights(2), ElementsAre(0, 300));
}

TEST_F(SlowSensors, ASensorThatIsMeasuringDoesNotBeginAgain) {
  send_command(2, "01 0001 0040");
  time.run_for(10s);
  const auto light = lights(2);
  ASSERT_GT(light.size(), 100u);
  EXPECT_NEAR((light.back() - 300) / 7.0, 10 / 0.25, 3) << "each fourth tick of 62.5 ms begins a measurement";
}

TEST_F(SimulatedMote, KnowsNoStop) {
  joined();
  send_command(2, "01 0003 0400");
  time.run_for(10s);
  send_command(2, "01 0000 ffff");
  came.clear();
  time.run_for(60s);
  EXPECT_THAT(lights(2), IsEmpty());
  time.run_for(5s);
  EXPECT_THAT(lights(2), SizeIs(1));
}

TEST_F(SimulatedMote, ReportsWithoutReadingWhenTheMaskIsEmpty) {
  joined();
  send_command(2, "01 0000 0400");
  time.run_for(5s);
  EXPECT_THAT(lights(2), SizeIs(5));
  EXPECT_THAT(lights(2), Each(0));
}

TEST_F(SimulatedMote, ReadsOnlyWhatTheMaskSays) {
  joined();
  send_command(2, "01 0002 0400");
  time.run_for(3s);
  EXPECT_THAT(lights(2), ElementsAre(0, 0, 0));
  const auto last = motes::decode_record(packets(2).back().net());
  EXPECT_EQ(std::get<motes::DemoReport>(*last).temperature, 6502);
}

TEST_F(SimulatedMote, IsFloodedByATruncatedCommandUntilAWholeOneComes) {
  auto options = plain();
  options.radio.collisions = false;  // one of twenty a second can hit the command
  joined(std::move(options));
  send_command(2, "01 0043");
  time.run_for(2s);
  EXPECT_GT(lights(2).size(), 30u);
  EXPECT_LT(lights(2).size(), 50u);
  send_command(2, "01 0003 0400");
  time.run_for(200ms);
  came.clear();
  time.run_for(10s);
  EXPECT_THAT(lights(2), SizeIs(10));
}

TEST_F(SimulatedMote, AcknowledgesReliableMessagesWhateverTheySay) {
  joined();
  send_command(2, "00", 1, 1);
  send_command(2, "02 0001 00000001", 2, 1);
  send_command(2, "24 01f4 0043", 3, 1, 10);
  send_command(2, "24 01f4 0043", 4, 1);
  send_command(2, "24 01f4 0043", 5, 0);
  time.run_for(1s);
  EXPECT_THAT(acknowledged(2), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(packets(2, motes::kTransportConnectionless), IsEmpty());
  for (const auto& ack : packets(2)) EXPECT_EQ(ack.net().counted, kFullCount);
  EXPECT_EQ(packets(2)[2].net().application, 10);
}

TEST_F(SimulatedMote, ReadsOnceAndReportsNothingWhenAskedForUpdatesByApplication5) {
  joined();
  send_command(2, "01 0003 0400");
  time.run_for(2500ms);
  send_command(2, "24 01f4 0043");
  time.run_for(3s);
  const auto light = lights(2);
  EXPECT_EQ(light.front(), 300);
  EXPECT_NE(std::adjacent_find(light.begin(), light.end(), [](auto a, auto b) { return b - a == 14; }), light.end());
}

TEST_F(SimulatedMote, ReadsOnceWithoutMoreInItsPeriodicReports) {
  joined();
  send_command(2, "24 01f4 0043");
  send_command(2, "01 0002 0400");
  time.run_for(4s);
  EXPECT_THAT(lights(2), ElementsAre(300, 300, 300, 300)) << "light is not in the mask";
}

TEST_F(SimulatedMote, AnswersOtherIslandsByTheirOwnAddress) {
  joined();
  const auto record = hex("00");
  auto message = command(2, record, 9, 1);
  message.source_island = 77;
  send(1, message);
  time.run_for(1s);
  ASSERT_THAT(packets(2), SizeIs(1));
  EXPECT_EQ(packets(2).front().net().destination_island, 77);
  came.clear();
  message.destination_mote = 1;
  send(2, message);
  time.run_for(1s);
  EXPECT_THAT(packets(), IsEmpty()) << "the sink's own answer gets no further";
}

TEST_F(SimulatedMote, IsReachedByABroadcastAsIsTheSink) {
  joined();
  send_command(motes::kBroadcast, "00", 0x77, 1);
  time.run_for(1s);
  EXPECT_THAT(acknowledged(1), ElementsAre(0x77));
  EXPECT_THAT(acknowledged(2), ElementsAre(0x77));
  EXPECT_THAT(acknowledged(3), ElementsAre(0x77));
}

TEST_F(SimulatedMote, BeginsItsSequenceNumbersAnewWithEachBoot) {
  joined();
  for (int round = 0; round < 3; ++round) {
    came.clear();
    world->mote(2).boot();
    time.run_for(1s);
    send_command(2, "00", 1, 1);
    EXPECT_EQ(packets(2, motes::kTransportAck).front().net().sequence, 0x247f);
  }
}

TEST_F(SimulatedMote, StopsForEverWhenItsQueueStalls) {
  joined();
  send_command(2, "01 0003 0400");
  time.run_for(3s);
  world->mote(2).stall();
  time.run_for(2s);
  came.clear();
  time.run_for(20s);
  EXPECT_THAT(packets(2), IsEmpty());
  EXPECT_GT(count("lost", 2), 5u);
  world->mote(2).boot();
  time.run_for(1s);
  send_command(2, "01 0003 0400");
  time.run_for(3s);
  EXPECT_THAT(lights(2), SizeIs(3));
}

TEST_F(SimulatedMote, ObeysActuateOnlyWithTheExtension) {
  auto options = plain();
  options.motes[1].mote.obey = true;
  joined(std::move(options));
  for (const std::uint16_t mote : {std::uint16_t{2}, std::uint16_t{3}}) {
    send_command(mote, "01 0001 0400");
    send_command(mote, "02 0001 00000001", 5, 1);
  }
  time.run_for(3s);
  EXPECT_EQ(count("actuator", 2), 0u);
  EXPECT_EQ(count("actuator", 3), 1u);
  EXPECT_EQ(lights(2)[1], 307);
  EXPECT_EQ(lights(3)[1], 307 + Mockup::kLedLight);
}

TEST_F(SimulatedMote, AnswersWithUpdatesOfItsWholeBoardWhereThatIsSwitchedOn) {
  auto options = plain();
  options.motes[0].mote.updates = true;
  options.motes[0].mote.board = *parse_build("EM1000");
  joined(std::move(options));
  send_command(2, "24 0200 ffff", 1, 0, 10);
  time.run_for(2s);
  const auto all = updates(2);
  ASSERT_THAT(all, SizeIs(4));
  const auto& readings = all.back().readings;
  ASSERT_THAT(readings, SizeIs(6));
  EXPECT_EQ(readings[0], (motes::RawReading{0x0001, {321}}));
  EXPECT_THAT(readings[2].words, SizeIs(2));
  EXPECT_EQ(readings[5].transducer, 0x0100);
  EXPECT_THAT(readings[5].words, SizeIs(5));
  came.clear();
  send_command(2, "24 0200 0041", 1, 0, 10);
  time.run_for(1s);
  EXPECT_THAT(updates(2).back().readings, SizeIs(2));
}

TEST_F(SimulatedMote, HasPartsOfOlderMessagesBehindItsRecords) {
  auto options = plain();
  for (auto& place : options.motes) place.mote.stale = 0.5;
  joined(std::move(options));
  send_command(2, "01 0003 0100");
  time.run_for(20s);
  EXPECT_GT(lights(2).size(), 50u);
  for (int i = 0; i < 20; ++i) send_command(2, "00", 5, 1);
  time.run_for(5s);
  const auto all = packets(2);
  const auto stale = std::count_if(all.begin(), all.end(), [](const Came& one) {
    const auto record = one.net().record;
    return std::any_of(record.begin() + 5, record.end(), [](auto byte) { return byte != 0; });
  });
  EXPECT_GT(stale, 0);
  EXPECT_LT(stale, static_cast<std::ptrdiff_t>(all.size()));
  for (const auto& one : packets(2, motes::kTransportAck)) EXPECT_NE(one.net().record[4], 0);
}

TEST_F(SimulatedMote, ShowsTheSignalsOfTheScript) {
  auto options = plain();
  options.motes.resize(1);
  make(std::move(options),
       "at 0s set 2 light 777\nat 0s ramp 2 temperature 1000 2000 over 10s\nat 20s sine 2 light 100 200 every 4s\n"
       "at 40s walk all light 500 600 every 100ms\nat 60s count 2@1 light\n");
  time.run_for(1s);
  send_command(2, "01 0003 0100");
  time.run_for(4900ms);
  EXPECT_THAT(lights(2), Each(777));
  const auto half = std::get<motes::DemoReport>(motes::decode_record(packets(2).back().net()).value());
  EXPECT_NEAR(half.temperature, 1550, 60);
  time.run_for(14s);
  came.clear();
  time.run_for(19s);
  const auto waves = lights(2);
  EXPECT_NEAR(*std::min_element(waves.begin() + 2, waves.end()), 100, 5);
  EXPECT_NEAR(*std::max_element(waves.begin() + 2, waves.end()), 200, 5);
  time.run_for(2s);
  came.clear();
  time.run_for(18s);
  const auto steps = lights(2);
  EXPECT_THAT(steps, Each(::testing::AllOf(::testing::Ge(500), ::testing::Le(600))));
  EXPECT_NE(*std::min_element(steps.begin(), steps.end()), *std::max_element(steps.begin(), steps.end()));
  time.run_for(2s);
  EXPECT_LT(lights(2).back(), 350);
}

TEST(MoteBuild, IsReadByNameOrMask) {
  EXPECT_EQ(parse_build("STANDARD")->declared, 0x6f52);
  EXPECT_EQ(parse_build("EM1000")->declared, 0x1f4f);
  EXPECT_EQ(parse_build("SE1000")->declared, 0x00b0);
  EXPECT_EQ(parse_build("00ff")->real, 0x00ff);
  for (const auto* bad : {"", "em1000", "ff", "00fff", "00fg", "-0ff"}) EXPECT_FALSE(parse_build(bad)) << bad;
}

}  // namespace
}  // namespace rubicon::motes_simulator
