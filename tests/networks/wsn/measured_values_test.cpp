#include "networks/wsn/wsn_fixture.h"
#include "networks/wsn/wsn_network.h"

namespace rubicon::networks::wsn {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

/// What is published of motes whose sensors need 210 ms: only what they measured (wsn.md 9.4).
class MeasuredValues : public MoteNetwork {
 protected:
  MeasuredValues() { options["board"] = "EM1000"; }
  void shows(std::uint16_t mote, std::size_t sensor, double value) {
    using Signal = motes_simulator::Signal;
    motes->mote(mote).sensors().show(sensor, {Signal::Shape::kSet, value, value, {}, {}});
  }
  void shows_light(double value) { shows(2, motes_simulator::kLightSensor, value); }
  std::vector<double> light() const { return readings("2", "light"); }
  std::vector<double> temperature() const { return readings("2", "temperature"); }
  static double lux(double count) { return count / 4096 * 1.5 / 100e3 * 0.625e9; }
};

TEST_F(MeasuredValues, TheFirstReportAfterTheFirstDemandIsNoReading) {
  start(1);
  ASSERT_TRUE(demand("2", {"light", "temperature"}));
  run(1500ms);
  EXPECT_GE(host.all<model::KeepAlive>().size(), 2u) << "a report came";
  EXPECT_THAT(light(), IsEmpty());
  run(5s);
  EXPECT_THAT(light(), SizeIs(Ge(4)));
  EXPECT_THAT(light(), Each(Ge(lux(300) - 1)));
  EXPECT_THAT(temperature(), Each(Ge(25.0))) << "-39.6 is what no measurement gives";
}

TEST_F(MeasuredValues, ASensorThatIsAddedMissesOneReportAndTheOtherNone) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  const auto before = light().size();
  ASSERT_TRUE(demand("2", {"light", "temperature"}));
  run(1500ms);
  EXPECT_EQ(light().size(), before + 1);
  EXPECT_THAT(temperature(), IsEmpty());
  run(3s);
  EXPECT_THAT(temperature(), AllOf(SizeIs(Ge(2)), Each(Ge(25.0))));
}

TEST_F(MeasuredValues, AfterAPauseTheLastValueOfBeforeIsNotHeardAgain) {
  start(1);
  shows_light(500);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  ASSERT_TRUE(demand("2", {}));
  run(30s);
  host.delivered.clear();
  shows_light(900);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  EXPECT_THAT(light(), AllOf(SizeIs(Ge(3)), Each(testing::DoubleNear(lux(900), 1))));
}

TEST_F(MeasuredValues, AfterASwitchOffAndOnNothingUnmeasuredIsPublished) {
  start(1);
  ASSERT_TRUE(demand("2", {"light", "temperature"}));
  run(5s);
  host.delivered.clear();
  motes->mote(2).boot();
  run(6s);
  EXPECT_THAT(temperature(), AllOf(SizeIs(Ge(3)), Each(Ge(25.0))));
  EXPECT_THAT(light(), Each(Ge(lux(300) - 1)));
}

TEST_F(MeasuredValues, ABadRadioBringsNothingUnmeasured) {
  start(1);
  motes->radio().options().loss = 0.3;
  for (int round = 0; round < 30; ++round) {
    ASSERT_TRUE(demand("2", {"temperature"}));
    run(6s);
    if (round % 3 == 0) motes->mote(2).boot();
    ASSERT_TRUE(demand("2", {}));
    run(2s);
  }
  EXPECT_THAT(temperature(), AllOf(SizeIs(Ge(30)), Each(Ge(25.0))));
  EXPECT_THAT(light(), IsEmpty()) << "there is no subscriber, and its field holds stale memory";
}

TEST_F(MeasuredValues, ARadioThatCarriesAllTwiceBringsNothingUnmeasured) {
  start(1);
  motes->radio().options().duplicates = 1;
  ASSERT_TRUE(demand("2", {"light", "temperature"}));
  run(10s);
  EXPECT_THAT(temperature(), AllOf(SizeIs(AllOf(Ge(7), Le(10))), Each(Ge(25.0))));
}

/// Another program on our share, as the original's tools are.
class MeasuredForOthers : public MeasuredValues {
 protected:
  MeasuredForOthers() { options["share"] = 9002; }
  void connect() {
    transport::TcpCallbacks calls;
    calls.received = [](ByteView) {};
    calls.failed = [](const Error&) {};
    program_ = std::move(host.files.open_tcp({{"127.0.0.1", 9002}}, std::move(calls))).value();
    ASSERT_TRUE(program_->send(Bytes{0x55, 0x20}));
    run(100ms);
  }
  void say(Bytes packet) {
    packet.insert(packet.begin(), static_cast<std::uint8_t>(packet.size()));
    ASSERT_TRUE(program_->send(packet));
  }
  void tell_to_read(std::uint16_t mask, std::uint16_t ticks) {
    const auto record = motes::encode_record(motes::PeriodicCommand{mask, ticks});
    say(motes::packet_of(motes::NetMessage{kIsland, 2, kIsland, motes::kBaseMote, 0, 0x1234, 0,
                                           motes::kTransportConnectionless, motes::kApplicationMockup, record}));
  }

 private:
  std::unique_ptr<transport::TcpStream> program_;
};

TEST_F(MeasuredForOthers, ValuesAreSeenFromTheSecondReportOnAndOnlyOfWhatTheyAskedFor) {
  start(1);
  connect();
  tell_to_read(0x0002, 1024);
  run(6s);
  EXPECT_THAT(temperature(), AllOf(SizeIs(AllOf(Ge(3), Le(5))), Each(Ge(25.0))));
  EXPECT_THAT(light(), IsEmpty());
}

TEST_F(MeasuredForOthers, TheirOwnIslandIsTakenIfItIsOurs) {
  start(1);
  connect();
  const auto before = events("island");
  say(motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, kIsland})));
  run(1s);
  EXPECT_EQ(events("island"), before + 1);
  EXPECT_EQ(counter("share-dropped-config"), 0u);
}

// --- The end of the island.

class LastWords : public MeasuredValues {
 protected:
  bool close() {
    return network->close([this] { ++closed; });
  }
  std::size_t stops() const {
    return static_cast<std::size_t>(std::count_if(happened.begin(), happened.end(), [](const auto& event) {
      return event.what == "executed" && base::to_hex(ByteView(event.record).first(5)) == "010000ffff";
    }));
  }
  int closed = 0;
};

TEST_F(LastWords, MotesThatWeActivatedAreStopped) {
  start(3);
  ASSERT_TRUE(demand("2", {"light"}));
  ASSERT_TRUE(demand("3", {"temperature"}));
  run(5s);
  ASSERT_TRUE(close());
  run(1s);
  EXPECT_EQ(closed, 1);
  EXPECT_EQ(stops(), 2u) << "and mote 4 gets none";
  EXPECT_FALSE(host.words.contains("go on sampling"));
}

TEST_F(LastWords, MotesThatDidNotAcknowledgeTheStopAreNamed) {
  start(2);
  ASSERT_TRUE(demand("2", {"light"}));
  ASSERT_TRUE(demand("3", {"light"}));
  run(5s);
  motes->mote(3).kill();
  ASSERT_TRUE(close());
  run(network::kClosingTime);
  EXPECT_EQ(closed, 1);
  EXPECT_EQ(stops(), 1u);
  EXPECT_TRUE(host.words.contains("motes 3 go on sampling"));
}

TEST_F(LastWords, ClosingDoesNotWaitForALostLine) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  motes->port(1).pull();
  run(1s);
  EXPECT_FALSE(close());
  EXPECT_TRUE(host.words.contains("motes 2 go on sampling"));
}

TEST_F(LastWords, NoMoteIsStoppedIfNoneWasActivated) {
  start(2);
  EXPECT_FALSE(close());
}

// --- A sink on another island.

TEST_F(MeasuredValues, ReadingsThatAreMissedBringTheSinkBackAtOnce) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(10s);
  motes->sink(1).reboot();
  run(3s);
  EXPECT_EQ(motes->sink(1).island(), 11) << "nothing is missing yet";
  ASSERT_TRUE(demand("2", {"light"}));  // as the proxy does when its value is stale
  run(300ms);
  EXPECT_EQ(motes->sink(1).island(), kIsland);
  const auto before = light().size();
  run(5s);
  EXPECT_GE(light().size(), before + 3);
}

TEST_F(MeasuredValues, AnUnansweredProbeBringsTheSinkBack) {
  start(3);
  run(10s);
  motes->sink(1).reboot();
  host.delivered.clear();
  ASSERT_TRUE(send("3", model::Probe{}));
  run(3s);
  EXPECT_EQ(motes->sink(1).island(), kIsland);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(Ge(1))) << "the second attempt is answered";
}

TEST_F(MeasuredValues, AMissingMoteAmongOthersThatAreHeardCausesNoCorrection) {
  start(2);
  ASSERT_TRUE(demand("2", {"light"}));
  ASSERT_TRUE(demand("3", {"light"}));
  run(10s);
  motes->mote(2).kill();
  const auto before = events("island");
  for (int i = 0; i < 5; ++i) {
    run(4s);
    std::ignore = demand("2", {"light"});
  }
  EXPECT_LE(events("island"), before + 1) << "the usual check each 30 s";
}

TEST_F(MeasuredValues, ASinkIsCorrectedAtMostEveryFiveSeconds) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(10s);
  motes->mote(2).kill();
  run(3s);
  const auto before = events("island");
  for (int i = 0; i < 100; ++i) {
    std::ignore = demand("2", {"light"});
    run(100ms);
  }
  EXPECT_LE(events("island"), before + 4);
}

TEST_F(MeasuredValues, MotesHaveThePropertiesThatTheirTypePromises) {
  start(1);
  std::set<std::string> offered, promised;
  const auto joins = host.all<model::Join>();
  for (const auto& capability : joins[0].second.capabilities) {
    if (capability.point.kind == Kind::kProperty)
      offered.insert(fmt::format("{} {}", capability.type_name, to_string(capability.access)));
  }
  for (const auto& type : TypeCatalogue::device_types()) {
    if (type.name != "mote") continue;
    for (const auto& property : type.properties)
      promised.insert(fmt::format("{} {}", property.property, to_string(property.access)));
  }
  EXPECT_EQ(offered, promised);
  EXPECT_EQ(offered, (std::set<std::string>{"mask read", "rate read-write"}));
}

}  // namespace
}  // namespace rubicon::networks::wsn
