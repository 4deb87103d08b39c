#include "scenarios/motes.h"
#include "motes/mote_records.h"

namespace rubicon::scenarios {
namespace {

using model::Outcome;
using testing::AllOf;
using testing::Each;
using testing::Ge;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Le;
using testing::Not;
using testing::SizeIs;

TEST_F(Motes, AMoteIsFullyVisibleFromItsJoinOn) {
  begin_world(2, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  EXPECT_EQ(seen(1, "proxy.wsn-1.devices"), R"(["2","3"])");
  EXPECT_EQ(seen(1, "proxy.wsn-1.2.sensor.light-1.value"), "");
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.sensor.light-1.status")["quality"], "unknown");
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.sensor.light-1.description")["unit"], "lx");
  EXPECT_EQ(seen(1, "proxy.wsn-1.property.line.value"), "up");
}

// --- Two sinks in one island.

/// Sinks 1 and 2, each with a mote 2, as networks wsn-1 and wsn-2 of island 1.
class TwoSinks : public Motes {
 protected:
  void SetUp() override {
    setup.sinks = 2;
    setup.add_motes(1, 2, 1, em1000());
    setup.add_motes(2, 2, 1, em1000());
    begin_world();
    auto& island = start(1, network("wsn-1", 1) + "\n  " + network("wsn-2", 2));
    answers_ = island.gateway().subscribe(MessageKind::kAcknowledge, [this](const Message& message) {
      answers.push_back(std::get<model::Acknowledge>(message.body));
    });
    scheduler.run_for(5s);
  }
  void write(const std::string& to_network) {
    Message message;
    message.source = {OwnerId(1), "", ""};
    message.destination = {OwnerId(1), to_network, "2"};
    message.body = model::Opaque{"mote/3/6/1/reliable", {0x01, 0x01, 0x2c, 0xbe, 0xef}};
    islands[1]->gateway().send(std::move(message));
    scheduler.run_for(5s);
  }
  std::vector<model::Acknowledge> answers;

 private:
  Handle answers_;
};

TEST_F(TwoSinks, WithAMote2EachHaveTwoDevices) {
  EXPECT_TRUE(reachable(1, "wsn-1.2"));
  EXPECT_TRUE(reachable(1, "wsn-2.2"));
  const auto subscription = want(1, "wsn-2.2.sensor.light-1");
  const auto first = hear(1, "wsn-1.2.sensor.light-1");
  const auto second = hear(1, "wsn-2.2.sensor.light-1");
  scheduler.run_for(10s);
  EXPECT_THAT(first->values, IsEmpty());
  EXPECT_THAT(second->values, SizeIs(Ge(7)));
}

TEST_F(TwoSinks, AMessageToAMoteThatTwoHaveIsRefusedAsAmbiguous) {
  write("");
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_NE(answers[0].outcome, Outcome::kSent);
  EXPECT_THAT(answers[0].text, AllOf(HasSubstr("wsn-1"), HasSubstr("wsn-2")));
  EXPECT_EQ(events("ignored"), 0U);
}

TEST_F(TwoSinks, AMessageThatNamesTheNetworkArrivesThere) {
  write("wsn-2");
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].outcome, Outcome::kSent) << answers[0].text;
  EXPECT_EQ(events("ignored", 2, 2), 1U);
  EXPECT_EQ(events("ignored", 2, 1), 0U);
}

// --- Demand.

TEST_F(Motes, BeforeTheFirstSubscriberTheRadioCarriesProbesAlone) {
  begin_world(3, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  happened.clear();
  from_sink.clear();
  scheduler.run_for(5min);
  EXPECT_EQ(events("executed", 2) + events("executed", 3) + events("executed", 4), 0U);
  EXPECT_THAT(happened, SizeIs(Ge(3 * 9)));
  for (const auto& event : happened) {
    if (event.what == "island") continue;  // from the island to its sink, not on the radio
    EXPECT_EQ(event.what, "ignored");
    ASSERT_FALSE(event.record.empty());
    EXPECT_EQ(event.record.front(), 0) << "a probe";
  }
  for (const auto& message : radio_messages(from_sink[1])) EXPECT_EQ(message.transport, motes::kTransportAck);
  for (const auto* mote : {"2", "3", "4"}) EXPECT_TRUE(reachable(1, std::string("wsn-1.") + mote));
}

TEST_F(Motes, OnlyTheSensorWithASubscriberIsRead) {
  begin_world(3, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  std::map<std::string, std::unique_ptr<Heard>> heard;
  for (const auto* sensor : {"2.sensor.light-1", "2.sensor.temperature-1", "3.sensor.light-1", "4.sensor.light-1"})
    heard[sensor] = hear(1, std::string("wsn-1.") + sensor);
  from_sink.clear();
  auto subscription = want(1, "wsn-1.2.sensor.temperature-1");
  scheduler.run_for(20s);
  EXPECT_THAT(heard["2.sensor.temperature-1"]->values, SizeIs(AllOf(Ge(17), Le(21)))) << "once a second";
  EXPECT_NEAR(std::stod(heard["2.sensor.temperature-1"]->values.front()), 25.4, 0.2);
  for (const auto* other : {"2.sensor.light-1", "3.sensor.light-1", "4.sensor.light-1"})
    EXPECT_THAT(heard[other]->values, IsEmpty()) << other;
  for (const auto& message : radio_messages(from_sink[1])) EXPECT_EQ(message.source_mote, 2);
  EXPECT_EQ(seen(1, "proxy.wsn-1.2.property.mask.value"), "2");
  subscription.reset();
  scheduler.run_for(3s);
  from_sink.clear();
  scheduler.run_for(60s);
  std::size_t reports = 0;
  for (const auto& message : radio_messages(from_sink[1])) reports += message.transport != motes::kTransportAck;
  EXPECT_LE(reports, 1U) << "one in 64 s: the firmware has no stop";
  EXPECT_EQ(seen(1, "proxy.wsn-1.2.property.mask.value"), "0");
}

TEST_F(Motes, ASubscriberMayWantAnotherPeriodThanTheProperty) {
  begin_world(1, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  const auto heard = hear(1, "wsn-1.2.sensor.light-1");
  const auto usual = want(1, "wsn-1.2.sensor.light-1");
  EXPECT_EQ(command(1, "wsn-1.2.property.rate", "5000").verdict, tuples::Verdict::kApplied);
  scheduler.run_for(3s);
  heard->values.clear();
  scheduler.run_for(30s);
  EXPECT_THAT(heard->values, SizeIs(AllOf(Ge(5), Le(7)))) << "the period of the property";
  Flow fast;
  fast.minimum = 500ms;
  auto hurried = want(1, "wsn-1.2.sensor.light-1", fast, kRobot + 1);
  scheduler.run_for(2s);
  heard->values.clear();
  scheduler.run_for(10s);
  EXPECT_THAT(heard->values, SizeIs(AllOf(Ge(18), Le(22)))) << "the period of the faster subscriber";
  hurried.reset();
  scheduler.run_for(6s);
  heard->values.clear();
  scheduler.run_for(30s);
  EXPECT_THAT(heard->values, SizeIs(AllOf(Ge(5), Le(7)))) << "and back again";
}

// --- Silence.

TEST_F(Motes, AMoteWhoseBatteryDiesIsUnreachableAndComesBackWithItsJoin) {
  begin_world(2, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  world->mote(2).kill();
  scheduler.run_for(70s);
  EXPECT_FALSE(reachable(1, "wsn-1.2"));
  EXPECT_THAT(seen(1, "proxy.wsn-1.2.status"), HasSubstr("silent for 60 s"));
  EXPECT_TRUE(reachable(1, "wsn-1.3"));
  world->mote(2).boot();
  scheduler.run_for(1s);
  EXPECT_TRUE(reachable(1, "wsn-1.2"));
}

class RebootedMotes : public Motes, public testing::WithParamInterface<bool> {};

TEST_P(RebootedMotes, OfTwentyAtOnceAllThatTheSinkListsAreThereAndNoneThatJoinedStaysLost) {
  setup.sink.reply_to_all = GetParam();
  begin_world(20, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(20s);
  const auto all = world->motes({});
  for (auto* mote : all) ASSERT_TRUE(reachable(1, "wsn-1." + std::to_string(mote->address())));
  for (auto* mote : all) mote->kill();
  scheduler.run_for(100s);
  for (auto* mote : all) ASSERT_FALSE(reachable(1, "wsn-1." + std::to_string(mote->address())));
  happened.clear();
  for (auto* mote : all) mote->boot();
  for (int i = 0; i < 500; ++i) {
    scheduler.run_for(10ms);
    const auto now = happened;  // what the sink listed 50 ms ago is there
    for (const auto& event : now) {
      if (event.what != "listed" || event.at + 50ms > now.back().at) continue;
      ASSERT_TRUE(reachable(1, "wsn-1." + std::to_string(event.mote))) << event.mote;
    }
  }
  std::size_t joined = 0, unheard = 0;
  for (auto* mote : all) {
    joined += mote->joined();
    unheard += mote->joined() && events("listed", mote->address()) == 0;
  }
  EXPECT_TRUE(GetParam() || joined >= 10);
  EXPECT_TRUE(GetParam() || unheard > 0) << "else this test shows nothing";
  scheduler.run_for(60s);
  for (auto* mote : all)
    EXPECT_EQ(reachable(1, "wsn-1." + std::to_string(mote->address())), mote->joined()) << mote->address();
}

INSTANTIATE_TEST_SUITE_P(WhoseSinkReplies, RebootedMotes, testing::Bool(),
                         [](const auto& one) { return one.param ? "ToAll" : "ToOne"; });

TEST_F(Motes, OfTwoHundredOfWhichMostAreGoneTheOthersStayReachable) {
  begin_world(200, em1000());
  start(1, "wsn-1: {type: wsn, board: EM1000, silence: 20s, share: no, source: \"network@" + std::string(kMotesHost) +
               ":19202\"}");
  scheduler.run_for(70s);  // one is switched on each 250 ms
  std::set<std::string> living;
  for (auto* mote : world->motes({})) {
    const auto name = "wsn-1." + std::to_string(mote->address());
    if (mote->address() % 22 != 3) {
      mote->kill();
    } else if (reachable(1, name)) {
      living.insert(name);
    }
  }
  ASSERT_THAT(living, SizeIs(Ge(8)));
  for (int i = 0; i < 300; ++i) {
    scheduler.run_for(1s);
    for (const auto& mote : living) ASSERT_TRUE(reachable(1, mote)) << mote << " after " << i << " s";
  }
  EXPECT_FALSE(reachable(1, "wsn-1.2"));
}

TEST_F(Motes, AMoteWhoseJoinNobodyHeardIsFoundByProbeWithinOnePeriod) {
  begin_world(2, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  world->mote(2).kill();
  scheduler.run_for(100s);
  ASSERT_FALSE(reachable(1, "wsn-1.2"));
  happened.clear();
  world->port(1).pull();  // the sink hears it, the computer does not: as when two joins overlap
  world->mote(2).boot();
  scheduler.run_for(900ms);
  ASSERT_TRUE(world->port(1).plug());
  ASSERT_TRUE(world->mote(2).joined());
  scheduler.run_for(60s);
  EXPECT_TRUE(reachable(1, "wsn-1.2"));
}

}  // namespace
}  // namespace rubicon::scenarios
