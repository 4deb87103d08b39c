#include <gmock/gmock.h>

#include "apps/simulators/motes/computer.h"
#include "apps/simulators/motes/scaled_scheduler.h"
#include "simulators/motes/simulated_world.h"

namespace rubicon::motes_simulator {
namespace {

using ::testing::ElementsAre;

class MoteWorld : public SimulatedWorld {};

TEST_F(MoteWorld, MovesAMoteBetweenSinksWhereItJoinsWithItsNextBoot) {
  auto options = plain();
  options.sinks = 2;
  make(std::move(options), "at 2s move 3 to 2\nat 4s reboot 3\nat 6s move 2 to none\nat 7s reboot 2");
  time.run_for(3s);
  EXPECT_EQ(listed(3, 1), 1u);
  EXPECT_EQ(listed(3, 2), 0u);
  time.run_for(7s);
  EXPECT_EQ(listed(3, 2), 1u);
  EXPECT_FALSE(world->mote(2).joined());
  EXPECT_EQ(listed(2, 1), 1u);
}

TEST_F(MoteWorld, LetsTheFirstReplyWinWhereAMoteHearsTwoSinks) {
  auto options = plain();
  options.sinks = 2;
  options.motes.resize(1);
  options.first_boot = 1s;
  make(std::move(options), "at 0s move 2 to 1,2");
  world->sink(2).received(motes::hdlc_acked_packet(
      1, motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, 12}))));
  time.run_for(3s);
  EXPECT_TRUE(world->mote(2).joined());
  EXPECT_EQ(listed(2, 1), world->mote(2).island() == 11 ? 1u : 0u);
  EXPECT_EQ(listed(2, 1) + listed(2, 2), 1u);
}

TEST_F(MoteWorld, KillsAndRebootsByTheScriptAgainAndAgain) {
  make(plain(), "at 1s kill 2\nat 2s reboot all over 1s\nat 5s repeat");
  time.run_for(21s);
  EXPECT_EQ(count("off", 2), 1u + 4u);
  EXPECT_EQ(count("boot", 2), 1u + 4u);
  EXPECT_EQ(count("boot", 3), 1u + 4u);
  EXPECT_EQ(listed(3, 1), 5u);
}

TEST_F(MoteWorld, AKilledMoteIsNotBootedByWhatWasPending) {
  make(plain(), "at 0s kill 3\nat 1s reboot all over 2s\nat 1500ms kill 3");
  time.run_for(900ms);
  EXPECT_FALSE(world->mote(3).on()) << "killed before its first boot";
  time.run_for(10s);
  EXPECT_FALSE(world->mote(3).on());
  EXPECT_TRUE(world->mote(2).joined());
  EXPECT_EQ(count("boot", 3), 0u);
}

TEST_F(MoteWorld, AMoteKilledBeforeTheComputerComesStaysOff) {
  auto options = plain();
  options.wait_for_computer = true;
  open(std::move(options), "at 0s kill 3\nat 10s reboot 3");
  const Client client(host, 19202);
  time.run_for(5s);
  EXPECT_TRUE(world->mote(2).joined());
  EXPECT_FALSE(world->mote(3).on());
  time.run_for(7s);
  EXPECT_TRUE(world->mote(3).joined());
}

TEST_F(MoteWorld, StepsForUnknownMotesAndSinksHaveNoEffect) {
  make(plain(),
       "at 0s kill 99\nat 0s reboot 5@9\nat 0s unplug 9 for 1s\nat 0s sink-reboot 9\nat 0s move 2 to 9\nat 0s set 99 "
       "light 1");
  time.run_for(5s);
  EXPECT_EQ(count("off"), 0u);
  EXPECT_THAT(world->radio().cells(world->mote(2).node()), ElementsAre(1)) << "not in no cell";
}

TEST(MoteScriptInAWorld, IsCheckedForUnknownMotesAndSinks) {
  WorldOptions world;
  world.sinks = 2;
  world.add_motes(1, 2, 3);
  world.add_motes(2, 7, 1);
  const auto error_of = [&](std::string_view script) {
    const auto checked = check_script(*parse_script(script), world);
    return checked ? std::string("good") : checked.error().text;
  };
  for (const auto* good : {"at 1s kill 4", "at 1s kill 7@2", "at 1s set all light 1", "at 1s move 4 to 1,2",
                           "at 1s move 4 to none", "at 1s sink-reboot 2", "at 1s loss 5"})
    EXPECT_EQ(error_of(good), "good") << good;
  EXPECT_EQ(error_of("at 2s loss 1\n\nat 1s kill 99"), "line 3: there is no mote 99, expected one of 2 to 7");
  EXPECT_EQ(error_of("at 1s loss 5 of 7@1"), "line 1: there is no mote 7@1, expected one of 2 to 7");
  EXPECT_EQ(error_of("at 1s move 4 to 2,3"), "line 1: there is no sink 3, expected 1 to 2");
  EXPECT_EQ(error_of("at 1s sink-reboot 3"), "line 1: there is no sink 3, expected 1 to 2");
  EXPECT_EQ(error_of("at 1s unplug 3 for 1s"), "line 1: there is no sink 3, expected 1 to 2");
}

TEST_F(MoteWorld, LosesAndDuplicatesRadioMessagesAsConfigured) {
  auto run = [this](std::string_view script) {
    auto options = plain();
    options.motes.resize(1);
    make(std::move(options), script);
    time.run_for(1s);
    came.clear();
    events.clear();
    const auto record = hex("01 0003 0080");
    send(1, command(2, record));
    time.run_for(60s);
    return lights(2).size();
  };
  const auto all = run("");
  EXPECT_NEAR(static_cast<double>(all), 60 * 8, 5);
  EXPECT_NEAR(static_cast<double>(run("at 3s loss 50")), static_cast<double>(all) / 2, 50);
  EXPECT_NEAR(static_cast<double>(run("at 3s loss 50 of 2")), static_cast<double>(all) / 2, 50);
  EXPECT_EQ(run("at 3s loss 50 of 3"), all);
  EXPECT_NEAR(static_cast<double>(run("at 3s duplicates 30")), static_cast<double>(all) * 1.3, 50);
}

TEST_F(MoteWorld, DelaysRadioMessagesAsConfigured) {
  joined();
  const auto answered_after = [this] {
    came.clear();
    const auto begin = time.now();
    const auto record = hex("00");
    send(1, command(2, record, 1, 1));
    time.run_for(3s);
    return packets(2).empty() ? Duration{} : packets(2).front().at - begin;
  };
  const auto at_once = answered_after();
  world->radio().options().delay = 300ms;
  EXPECT_GT(answered_after(), at_once + 550ms);
}

TEST_F(MoteWorld, IsTheSameWithTheSameSeedAndAnotherWithAnother) {
  const auto run = [this](std::uint64_t seed) {
    auto options = plain();
    options.add_motes(1, 4, 10);
    options.sink.stale = 0.3;
    options.sink.ack = {};
    options.radio.loss = 0.1;
    options.radio.duplicates = 0.1;
    options.seed = seed;
    out.clear();
    lines.clear();
    make(std::move(options), "at 3s reboot all over 1s\nat 2s walk all light 0 1000 every 50ms");
    for (std::uint8_t i = 0; i < 12; ++i) {
      const auto record = hex("01 0003 0040");
      send(i, command(static_cast<std::uint16_t>(2 + i), record, i, 1));
      time.run_for(500ms);
    }
    return std::pair(out, lines);
  };
  const auto first = run(7);
  EXPECT_EQ(first, run(7));
  EXPECT_GT(first.first.size(), 10000u);
  EXPECT_NE(first.first, run(8).first);
}

TEST_F(MoteWorld, RecordsItselfWithAComputerOfItsOwn) {
  for (const bool updates : {false, true}) {
    auto options = plain();
    for (auto& place : options.motes) {
      place.mote.updates = updates;
      place.mote.board = *parse_build("EM1000");
    }
    make(std::move(options));
    std::vector<std::pair<bool, Bytes>> seen;
    world->sink(1).watch(
        [&](bool written, ByteView packet) { seen.emplace_back(written, Bytes(packet.begin(), packet.end())); });
    const Computer computer({42, 1024, updates}, world->sink(1), time);
    time.run_for(10s);
    std::map<std::pair<bool, int>, int> kinds;
    for (const auto& [written, bytes] : seen) {
      const auto packet = motes::decode_packet(bytes).value();
      const auto message = motes::decode_net(packet.payload);
      ++kinds[{written, message ? message->record[0] : -1}];
    }
    EXPECT_EQ((kinds[{true, -1}]), 1) << "CONFIG";
    EXPECT_EQ((kinds[{false, 0x10}]), 2) << "joins";
    EXPECT_EQ((kinds[{false, 0x17}]), 2) << "acknowledgements";
    EXPECT_GT((kinds[{false, updates ? 0x23 : 0x22}]), 14);
    EXPECT_EQ(world->mote(2).island(), 42);
  }
}

/// Counts the calls to the scheduler.
class Counted final : public Scheduler {
 public:
  explicit Counted(Scheduler& real) : real_(real) {}
  SteadyTime now() const override { return real_.now(); }
  WallTime wall_now() const override { return real_.wall_now(); }
  void post(std::function<void()> call) override {
    ++asked;
    real_.post(std::move(call));
  }
  Timer at(SteadyTime when, std::function<void()> call) override {
    ++asked;
    return real_.at(when, std::move(call));
  }
  bool on_loop_thread() const override { return real_.on_loop_thread(); }
  std::size_t asked = 0;

 private:
  Scheduler& real_;
};

TEST_F(MoteWorld, OfAHundredSinksWithTwentyMotesIsIdleWithoutTraffic) {
  WorldOptions options;
  options.sinks = 100;
  for (std::uint16_t sink = 1; sink <= 100; ++sink) options.add_motes(sink, static_cast<std::uint16_t>(sink * 20), 20);
  Counted counted(time);
  World big(std::move(options), counted);
  time.run_for(10s);
  const auto all = big.motes({});
  const auto joined_ones = std::count_if(all.begin(), all.end(), [](const auto* mote) { return mote->joined(); });
  EXPECT_GT(joined_ones, 1900);
  EXPECT_GT(counted.asked, 2000u);
  const auto asked = counted.asked;
  time.run_for(std::chrono::hours(24));
  EXPECT_EQ(counted.asked, asked) << "a day without any traffic";
}

TEST(ScaledTime, GoesSoManyTimesAsFast) {
  VirtualScheduler real;
  ScaledScheduler scaled(real, 10);
  const auto began = scaled.now();
  SteadyTime rang{};
  const auto timer = scaled.after(5s, [&] { rang = real.now(); });
  const auto real_began = real.now();
  real.run_for(1s);
  EXPECT_EQ(scaled.now() - began, 10s);
  EXPECT_NEAR(static_cast<double>((rang - real_began).count()), 5e8, 1e3);
}

TEST(MoteEvent, IsALineOfJson) {
  EXPECT_EQ(to_json({1500ms, "executed", 1, 7, std::uint16_t{9}, std::nullopt, {0x01, 0xff}}),
            R"({"at":1.500000,"event":"executed","sink":1,"mote":7,"sequence":9,"record":"01ff"})");
  EXPECT_EQ(to_json({0s, "actuator", 0, 7, std::nullopt, -5, {}}),
            R"({"at":0.000000,"event":"actuator","mote":7,"value":-5})");
}

/// A node that counts what it hears.
class Listener final : public RadioNode {
 public:
  bool hear(const AirMessage& message) override {
    ++heard;
    return message.destination == address;
  }
  std::uint16_t address = 0;
  int heard = 0;
};

TEST(Air, TakesAsLongAsTheSpecSays) {
  EXPECT_NEAR(std::chrono::duration<double>(Radio::airtime(114)).count(), 4.26e-3, 1e-5);
  EXPECT_NEAR(std::chrono::duration<double>(Radio::airtime(28)).count(), 1.50e-3, 1e-5);
}

TEST(Air, ReachesWhoIsInACellAndAcknowledgesWhatWasForOne) {
  VirtualScheduler time;
  Radio radio({}, time);
  Listener near, both, far;
  const auto from = radio.add(near, {1});
  radio.add(both, {1, 2});
  radio.add(far, {2});
  both.address = 5;
  std::vector<bool> done;
  radio.transmit(from, {1, 5, 1, Bytes(10)}, [&](bool acknowledged) { done.push_back(acknowledged); });
  time.run_for(1s);
  radio.transmit(from, {1, 6, 1, Bytes(10)}, [&](bool acknowledged) { done.push_back(acknowledged); });
  time.run_for(1s);
  EXPECT_THAT(done, ElementsAre(true, false));
  EXPECT_EQ(both.heard, 2);
  EXPECT_EQ(near.heard + far.heard, 0);
}

TEST(Air, SpoilsTwoThatBeginTogetherAndLaterOnesWait) {
  VirtualScheduler time;
  Radio radio({}, time);
  Listener one, two, three;
  const auto first = radio.add(one, {1});
  const auto second = radio.add(two, {1});
  radio.add(three, {1});
  radio.transmit(first, {1, 0xffff, 1, Bytes(50)}, {});
  EXPECT_FALSE(radio.busy(second)) << "not noticed yet";
  radio.transmit(second, {1, 0xffff, 1, Bytes(50)}, {});
  time.run_for(1ms);
  EXPECT_TRUE(radio.busy(second));
  time.run_for(1s);
  EXPECT_EQ(three.heard, 0);
  EXPECT_FALSE(radio.busy(second));
}

TEST(Air, QueuesFourMessagesOfANodeAndLosesMore) {
  VirtualScheduler time;
  Radio radio({}, time);
  Listener sender, receiver;
  Transmitter transmitter(radio, time);
  transmitter.start(radio.add(sender, {1}), 2);
  radio.add(receiver, {1});
  int taken = 0;
  for (int i = 0; i < 6; ++i) taken += transmitter.send({1, 0xffff, 2, Bytes(20)}) ? 1 : 0;
  EXPECT_EQ(taken, 4);
  time.run_for(1s);
  EXPECT_EQ(receiver.heard, 4);
}

}  // namespace
}  // namespace rubicon::motes_simulator
