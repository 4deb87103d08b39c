#include <gmock/gmock.h>

#include <set>

#include "simulators/motes/simulated_sink.h"

namespace rubicon::motes_simulator {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// wsn.md 9.1, 9.2.
class Joining : public SimulatedSink {
 protected:
  std::vector<motes::Joined> joins() const {
    std::vector<motes::Joined> all;
    for (const auto& one : packets()) {
      const auto record = motes::decode_record(one.net());
      if (record && std::holds_alternative<motes::Joined>(*record)) all.push_back(std::get<motes::Joined>(*record));
    }
    return all;
  }
  void set_island(std::uint16_t island) {
    send(motes::hdlc_acked_packet(
        1, motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, island}))));
    time.run_for(200ms);
  }
  void probe(std::uint16_t mote, std::uint16_t island) {
    const auto record = hex("00");
    auto message = command(mote, record, 0x55, 1);
    message.destination_island = message.source_island = island;
    send(1, message);
    time.run_for(500ms);
  }
};

/// Counts the join requests on the air.
class Ear final : public RadioNode {
 public:
  bool hear(const AirMessage& message) override {
    heard.push_back(message);
    return message.destination == 1 && answers;
  }
  std::vector<AirMessage> heard;
  bool answers = false;
};

TEST_F(Joining, IsToldByTheSinkWithWhatTheMoteDeclares) {
  auto options = plain();
  options.motes[1].mote.board = *parse_build("STANDARD");
  make(std::move(options));
  time.run_for(1s);
  const auto all = joins();
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].island, 11);
  EXPECT_EQ(all[0].mote, 2);
  EXPECT_EQ(all[0].mote_type, 1);
  EXPECT_EQ(all[0].transducers, 0x00b0);
  EXPECT_EQ(all[0].actuators, 1);
  EXPECT_EQ(all[1].transducers, 0x6f52);
  EXPECT_EQ(packets().front().net().sequence, 0);
  EXPECT_EQ(packets().front().net().counted, kFullCount);
}

TEST_F(Joining, IsAskedForSevenTimesAndNeverAgainUntilReboot) {
  auto options = plain();
  options.motes.resize(1);
  make(std::move(options));
  world->sink(1).kill();
  Ear ear;
  world->radio().add(ear, {1});
  const auto begin = time.now();
  time.run_for(200ms + 2925ms);
  EXPECT_THAT(ear.heard, SizeIs(6));
  time.run_for(30ms);
  EXPECT_THAT(ear.heard, SizeIs(7));
  time.run_for(std::chrono::hours(1));
  EXPECT_THAT(ear.heard, SizeIs(7));
  EXPECT_EQ(ear.heard.front().type, kAirJoinRequest);
  EXPECT_GT(time.now(), begin);
  world->sink(1).reboot();
  world->mote(2).boot();
  time.run_for(1s);
  EXPECT_THAT(joins(), SizeIs(1));
}

TEST_F(Joining, GoesOnUntilTheAckJoinIsAcknowledgedByTheRadio) {
  auto options = plain();
  options.motes.resize(1);
  options.radio.loss = 1;
  make(std::move(options));
  time.run_for(1200ms);
  EXPECT_FALSE(world->mote(2).joined());
  world->radio().options().loss = 0;
  time.run_for(600ms);
  EXPECT_TRUE(world->mote(2).joined());
  EXPECT_THAT(joins(), SizeIs(1));
}

TEST_F(Joining, OfTwoAtOnceIsToldOfOneOnlyThoughBothBelieveIt) {
  auto options = plain();
  options.boot_spacing = {};
  bool seen = false;
  for (std::uint64_t seed = 1; seed < 50 && !seen; ++seed) {
    // Back-offs depend on the addresses alone: other motes collide otherwise.
    options.motes.clear();
    options.add_motes(1, static_cast<std::uint16_t>(seed * 3), 2);
    came.clear();
    make(options);
    time.run_for(5s);
    const bool both = world->motes({})[0]->joined() && world->motes({})[1]->joined();
    seen = both && joins().size() == 1;
  }
  EXPECT_TRUE(seen);
}

TEST_F(Joining, RepliesToOthersAreAnsweredWithGarbage) {
  auto options = plain();
  options.motes.resize(1);
  options.first_boot = 1h;
  make(std::move(options));
  Ear ear;
  const auto node = world->radio().add(ear, {1});
  world->sink(1).kill();
  world->mote(2).boot();
  time.run_for(100ms);
  world->radio().transmit(node, {kAirJoinReply, 0xffff, 1, hex("000b 0009 00000000 7777")}, {});
  time.run_for(100ms);
  ASSERT_THAT(ear.heard, SizeIs(2));
  EXPECT_EQ(ear.heard[1].type, kAirAckJoin);
  EXPECT_THAT(ear.heard[1].payload, SizeIs(14));
  EXPECT_FALSE(world->mote(2).joined());
}

TEST_F(Joining, GarbageAckJoinsAreNotTold) {
  make(plain());
  Ear ear;
  const auto node = world->radio().add(ear, {1});
  for (int i = 0; i < 20; ++i) {
    world->radio().transmit(node, {kAirAckJoin, 1, 9, hex("000b 0001 000b 0009 1234 01 00b0 01")}, {});
    time.run_for(100ms);
  }
  EXPECT_THAT(joins(), SizeIs(2));
}

TEST_F(Joining, ARequestOfOneThatHasJoinedIsAnsweredAgain) {
  joined();
  world->mote(2).boot();
  time.run_for(1s);
  ASSERT_THAT(joins(), SizeIs(1));
  EXPECT_EQ(joins().front().mote, 2);
}

TEST_F(Joining, TakesTheIslandTheSinkHasAndForgetsItWithAReboot) {
  auto options = plain();
  options.first_boot = 1s;
  make(std::move(options));
  set_island(42);
  time.run_for(2s);
  ASSERT_THAT(joins(), SizeIs(2));
  EXPECT_EQ(joins().front().island, 42);
  probe(2, 42);
  EXPECT_THAT(acknowledged(2), SizeIs(1));

  world->sink(1).reboot();
  EXPECT_EQ(world->sink(1).island(), 11);
  came.clear();
  probe(2, 42);
  EXPECT_THAT(packets(2), IsEmpty()) << "a sink of another island drops the messages of its motes";
  set_island(42);
  came.clear();
  probe(2, 42);
  EXPECT_THAT(acknowledged(2), SizeIs(1)) << "they are back when the id is set back";
}

TEST_F(Joining, LeavesOldMotesOnTheirIslandWhenTheIdChanges) {
  joined();
  set_island(12);
  probe(2, 12);
  EXPECT_THAT(packets(2), IsEmpty());
  world->mote(2).boot();
  time.run_for(1s);
  probe(2, 12);
  EXPECT_THAT(acknowledged(2), SizeIs(1));
}

TEST_F(Joining, OfTwoHundredAtOnceTheSinkTellsFewerThanBelieveIt) {
  WorldOptions options;
  options.add_motes(1, 2, 200);
  options.radio.collisions = false;
  options.boot_spacing = {};
  make(std::move(options));
  time.run_for(10s);
  const auto all = world->motes({});
  const auto believe = std::count_if(all.begin(), all.end(), [](const auto* mote) { return mote->joined(); });
  std::set<std::uint16_t> listed;
  for (const auto& join : joins()) listed.insert(join.mote);
  EXPECT_GT(listed.size(), 0u);
  EXPECT_LT(listed.size(), static_cast<std::size_t>(believe));
}

}  // namespace
}  // namespace rubicon::motes_simulator
