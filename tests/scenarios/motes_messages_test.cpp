#include "motes/mote_records.h"
#include "scenarios/motes.h"

namespace rubicon::scenarios {
namespace {

using model::Opaque;
using model::Outcome;
using testing::HasSubstr;
using testing::SizeIs;

/// Island 1 with mote 2, island 2 with mote 3, each behind its own sink.
class MessagesOfMotes : public Motes {
 protected:
  void SetUp() override {
    setup.sinks = 2;
    setup.add_motes(1, 2, 1, em1000());
    setup.add_motes(2, 3, 1, em1000());
    begin_world();
    start(1, network("wsn-1", 1));
    start(2, network("wsn-1", 2));
    scheduler.run_for(5s);
    to_sink.clear();
    from_sink.clear();
  }
  /// Mote 2 of island 1 writes a message of the learning layer to a component of island 2, reliably.
  void write_to_island_2(std::uint16_t mote) {
    const motes::NetMessage written{
        2, mote, 1, 2, 1, 0x1234, 0x66, motes::kTransportConnectionless, motes::kApplicationLearning, kRecord};
    world->radio().transmit(world->mote(2).node(),
                            {motes_simulator::kAirNetMessage, motes::kSinkMote, 2, motes::encode_net(written)},
                            [](bool) {});
    scheduler.run_for(5s);
  }
  const Bytes kRecord{0x13, 0x01, 0x02};
};

TEST_F(MessagesOfMotes, GoToMotesOfOtherIslandsAndTheAcknowledgementComesBack) {
  write_to_island_2(3);
  const auto arrived = radio_messages(to_sink[2]);
  ASSERT_THAT(arrived, SizeIs(1)) << "once, although it is reliable: only the sender repeats it";
  EXPECT_EQ(arrived[0].source_island, 1);
  EXPECT_EQ(arrived[0].source_mote, 2);
  EXPECT_EQ(arrived[0].sequence, 0x1234);
  EXPECT_EQ(arrived[0].reliable, 1);
  ASSERT_EQ(events("ignored", 3, 2), 1U);
  EXPECT_EQ(base::to_hex(ByteView(happened.back().record).first(3)), "130102");
  const auto back = radio_messages(to_sink[1]);
  ASSERT_THAT(back, SizeIs(1)) << "the acknowledgement, for mote 2 of island 1";
  EXPECT_EQ(back[0].transport, motes::kTransportAck);
  EXPECT_EQ(back[0].destination_island, 1);
  EXPECT_EQ(back[0].destination_mote, 2);
  EXPECT_EQ(back[0].source_island, 2);
  EXPECT_EQ(back[0].source_mote, 3);
  EXPECT_EQ(base::to_hex(back[0].record.first(4)), "17123400");
}

TEST_F(MessagesOfMotes, GoToTheComponentsOfOtherIslands) {
  std::vector<Message> heard;
  const auto ears =
      islands[2]->gateway().subscribe(MessageKind::kOpaque, [&](const Message& message) { heard.push_back(message); });
  write_to_island_2(motes::kBaseMote);
  ASSERT_THAT(heard, SizeIs(1));
  EXPECT_EQ(heard[0].source.island, OwnerId(1));
  EXPECT_EQ(heard[0].source.device, "2");
  const auto& opaque = std::get<Opaque>(heard[0].body);
  EXPECT_EQ(opaque.type, "mote/3/6/19/reliable/4660");
  EXPECT_EQ(base::to_hex(ByteView(opaque.bytes).first(3)), "130102");
}

TEST_F(MessagesOfMotes, ComeFromComponentsOfOtherIslandsWhoHearWhetherTheyArrived) {
  std::vector<model::Acknowledge> answers;
  const auto ears = islands[1]->gateway().subscribe(MessageKind::kAcknowledge, [&](const Message& message) {
    answers.push_back(std::get<model::Acknowledge>(message.body));
  });
  const auto write = [&](const std::string& device) {
    Message message;
    message.source = {OwnerId(1), "", ""};
    message.destination = {OwnerId(2), "", device};
    message.body = Opaque{"mote/3/6/19", kRecord};
    islands[1]->gateway().send(std::move(message));
    scheduler.run_for(5s);
  };
  write("3");
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].outcome, Outcome::kSent) << answers[0].text;
  EXPECT_EQ(events("ignored", 3, 2), 1U);
  write("4");
  ASSERT_THAT(answers, SizeIs(2));
  EXPECT_NE(answers[1].outcome, Outcome::kSent) << "there is no such mote";
  EXPECT_THAT(radio_messages(to_sink[2]), SizeIs(1));
}

TEST_F(MessagesOfMotes, AreCarriedOnceThoughTheRadioCarriesThemTwice) {
  world->radio().options().duplicates = 1;
  write_to_island_2(3);
  EXPECT_THAT(radio_messages(from_sink[1]), SizeIs(2));
  EXPECT_THAT(radio_messages(to_sink[2]), SizeIs(1));
}

// --- Readings of motes with the Control module.

TEST_F(Motes, WithTheControlModuleSendAllThatIsWanted) {
  auto able = em1000();
  able.updates = true;
  begin_world(2, able);
  for (const auto& [sensor, count] : {std::pair("humidity", 1200), {"temperature", 6460}, {"rssi3", 35}}) {
    const auto place = motes_simulator::parse_sensor(sensor).value();
    const double counts = count;
    world->mote(2).sensors().show(place, {motes_simulator::Signal::Shape::kSet, counts, counts, {}, {}});
  }
  start(1, network("wsn-1", 1, "sampling: read-updates"));
  scheduler.run_for(5s);
  const auto humidity = hear(1, "wsn-1.2.sensor.humidity-1");
  const auto strength = hear(1, "wsn-1.2.sensor.rssi-3");
  const auto light = hear(1, "wsn-1.2.sensor.light-1");
  const auto other = hear(1, "wsn-1.3.sensor.humidity-1");
  Flow fast;
  fast.minimum = 500ms;
  const auto first = want(1, "wsn-1.2.sensor.humidity-1", fast);
  const auto second = want(1, "wsn-1.2.sensor.rssi-3");
  scheduler.run_for(10s);
  ASSERT_THAT(humidity->values, SizeIs(testing::Ge(17)));
  EXPECT_NEAR(std::stod(humidity->values.back()), 40.57, 0.01) << "wsn.md 11: 1200 at 25 degC";
  ASSERT_THAT(strength->values, SizeIs(testing::Ge(17)));
  EXPECT_EQ(std::stod(strength->values.back()), -60) << "35 - 95 dBm";
  EXPECT_THAT(light->values, testing::IsEmpty());
  EXPECT_THAT(other->values, testing::IsEmpty());
}

}  // namespace
}  // namespace rubicon::scenarios
