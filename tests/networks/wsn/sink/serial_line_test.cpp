#include <gmock/gmock.h>

#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A sink on a serial line, made as a network makes it.
class SerialLineTest : public SinkTold {
 protected:
  static constexpr auto kPath = "/dev/serial/by-id/usb-Moteiv_tmote_sky-if00-port0";

  SerialLineTest() {
    options.source = parse_source(std::string("serial@") + kPath + ":telosb").value();
    mote.plug(transports.serial(), kPath);
  }
  void connect() {
    sink = make_sink(options, time, transports, calls());
    ASSERT_TRUE(sink->open());
    time.run_for(100ms);
    ASSERT_EQ(phase(), Phase::kUp) << sink->state().reason;
    mote.executed.clear();
  }

  FakeSink mote{time};
};

TEST_F(SerialLineTest, IsOpenedWithTheBaudRateOfItsPlatform) {
  connect();
  ASSERT_NE(transports.serial().opened(kPath), nullptr);
  EXPECT_EQ(transports.serial().opened(kPath)->baud, 115200U);
  sink.reset();
  EXPECT_EQ(transports.serial().opened(kPath), nullptr) << "destroyed = closed";
}

TEST_F(SerialLineTest, CarriesPacketsBothWays) {
  transports.serial().segment = 1;
  connect();
  mote.say(numbered(7));
  ASSERT_TRUE(send(1));
  time.run_for(1s);
  EXPECT_THAT(received, ElementsAre(numbered(7)));
  EXPECT_THAT(mote.executed, ElementsAre(numbered(1)));
  EXPECT_EQ(outcome(1), SendResult::kAcknowledged);
}

TEST_F(SerialLineTest, SurvivesThatTheSinkIsPulledOutAndPluggedInAgain) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2, {Lane::kClient, 24h, false}));
  time.run_for(10ms);
  mote.hang_up();
  time.run_for(10s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr(kPath));
  EXPECT_EQ(phase(), Phase::kOff);
  ASSERT_TRUE(send(3));
  mote.answers = true;
  mote.executed.clear();
  mote.plug(transports.serial(), kPath);
  time.run_for(2s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_THAT(mote.executed, ElementsAre(set_island(42), numbered(1), numbered(3), numbered(2)));
  EXPECT_EQ(failures.size(), 1U);
}

TEST_F(SerialLineTest, IsNotThereWhereNothingIsPluggedIn) {
  mote.hang_up();
  sink = make_sink(options, time, transports, calls());
  const auto opened = sink->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(opened.error().text, HasSubstr(kPath));
  EXPECT_EQ(phase(), Phase::kOff);
  time.run_for(1s);
  EXPECT_THAT(failures, IsEmpty());
}

TEST_F(SerialLineTest, BelongsToOneProgramOnly) {
  connect();
  auto other = make_sink(options, time, transports, {});
  EXPECT_EQ(other->open().error().code, ErrorCode::kBusy);
}

/// The sink came back from a power cut on its built-in island, and does not report it (wsn.md 9.1).
TEST_F(SerialLineTest, GreetsAgainAfterEachReplug) {
  connect();
  for (int i = 0; i < 3; ++i) {
    mote.hang_up();
    time.run_for(3s);
    mote.executed.clear();
    mote.plug(transports.serial(), kPath);
    time.run_for(3s);
    EXPECT_THAT(mote.executed, ElementsAre(set_island(42)));
  }
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
