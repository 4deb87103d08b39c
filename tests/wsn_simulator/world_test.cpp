#include <gmock/gmock.h>

#include "apps/rubicon-motes/computer.h"
#include "apps/rubicon-motes/scaled_scheduler.h"
#include "simulated_sink.h"
#include "transport/memory_transports.h"

namespace rubicon::mote_simulator {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A computer that is connected to a sink's port.
struct Client {
  Client(transport::MemoryTransports& host, std::uint16_t port) {
    transport::TcpOptions options;
    options.remote = {"127.0.0.1", port};
    stream = host.open_tcp(options, {[this] { ++connected; },
                                     [this](ByteView bytes) {
                                       all += bytes.size();
                                       while (auto frame = reader.next(bytes)) ++frames;
                                     },
                                     [this](const Error&) { ++failed; }})
                 .value();
  }
  std::unique_ptr<transport::TcpStream> stream;
  motes::HdlcReader reader;
  std::size_t all = 0;
  int connected = 0, failed = 0, frames = 0;
};

class MoteWorld : public SimulatedSink {
 protected:
  MoteWorld() { host.join(net); }
  ~MoteWorld() override { world.reset(); }  // before the network it is on
  void open(WorldOptions options, std::string_view script = "") {
    make(std::move(options), script, false);
    for (std::uint16_t sink = 1; sink <= world->sinks(); ++sink)
      ASSERT_TRUE(world->open(sink, on_memory(net.tcp, {"127.0.0.1", static_cast<std::uint16_t>(19201 + sink)})));
  }
  /// A reliable message to the sink itself: it is acknowledged by the line and by the application.
  static Bytes probe_of_sink() {
    const auto record = hex("00");
    return motes::hdlc_acked_packet(9, motes::packet_of(command(1, record, 1, 1)));
  }
  /// As often as the sink told of it.
  std::size_t listed(std::uint16_t mote, std::uint16_t sink) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const Event& event) {
      return event.what == "listed" && event.mote == mote && event.sink == sink;
    }));
  }

  transport::MemoryNet net{time};
  transport::MemoryTransports host;
};

TEST_F(MoteWorld, SpeaksOverAPortToOneComputerAtATime) {
  open(plain());
  Client first(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(first.frames, 2);
  Client second(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(second.failed, 1);
  EXPECT_EQ(first.failed, 0);
  EXPECT_THAT(count("refused"), 1u);
  const auto record = hex("00");
  const auto frame = motes::hdlc_acked_packet(9, motes::packet_of(command(2, record, 1, 1)));
  ASSERT_TRUE(first.stream->send(frame));
  time.run_for(1s);
  EXPECT_EQ(first.frames, 4);
  first.stream.reset();
  time.run_for(1s);
  const Client third(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(third.failed, 0);
}

TEST_F(MoteWorld, RunsOnWhileNobodyIsThereAndItsBytesAreLost) {
  open(plain());
  time.run_for(5s);
  EXPECT_TRUE(world->mote(2).joined());
  const Client late(host, 19202);
  time.run_for(1min);
  EXPECT_EQ(late.all, 0u);
}

TEST_F(MoteWorld, BootsItsMotesWhenSomebodyHasComeIfItIsToWait) {
  auto options = plain();
  options.wait_for_computer = true;
  open(std::move(options));
  time.run_for(1min);
  EXPECT_FALSE(world->mote(2).on());
  const Client client(host, 19202);
  time.run_for(2s);
  EXPECT_EQ(client.frames, 2);
}

TEST_F(MoteWorld, HoldsUpAComputerThatSendsFasterThanTheLine) {
  open(plain());
  Client client(host, 19202);
  time.run_for(1s);
  const auto record = hex("00");
  const auto frame = motes::hdlc_acked_packet(9, motes::packet_of(command(2, record, 1, 0)));
  for (int i = 0; i < 3000; ++i) ASSERT_TRUE(client.stream->send(frame));
  time.run_for(50ms);
  EXPECT_TRUE(world->sink(1).congested());
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(client.stream->send(frame));
  time.run_for(1s);
  EXPECT_EQ(client.stream->queued(), 100 * frame.size()) << "they wait at the computer";
  time.run_for(60s);
  EXPECT_EQ(client.stream->queued(), 0u);
  EXPECT_GT(client.frames, 2000);
  EXPECT_FALSE(world->sink(1).congested());
}

TEST_F(MoteWorld, HoldsUpGarbageLikeFramesAndHearsWhatComesBehindIt) {
  open(plain());
  Client client(host, 19202);
  time.run_for(2s);
  const Bytes garbage(30000, 0x55);  // 2.6 s of the line
  ASSERT_TRUE(client.stream->send(garbage));
  time.run_for(50ms);
  EXPECT_TRUE(world->sink(1).congested());
  ASSERT_TRUE(client.stream->send(garbage));
  ASSERT_TRUE(client.stream->send(probe_of_sink()));
  time.run_for(1s);
  EXPECT_GT(client.stream->queued(), 0u) << "it waits at the computer";
  const auto frames = client.frames;
  time.run_for(5s);
  EXPECT_EQ(client.stream->queued(), 0u);
  EXPECT_EQ(client.frames, frames + 2) << "acknowledged and answered";
  EXPECT_FALSE(world->sink(1).congested());
}

TEST_F(MoteWorld, ForgetsWhatIsNotOnTheLineYetWhenTheComputerHangsUp) {
  open(plain());
  {
    Client client(host, 19202);
    time.run_for(2s);
    ASSERT_TRUE(client.stream->send(Bytes(60000, 0x55)));
    ASSERT_TRUE(client.stream->send(probe_of_sink()));
    time.run_for(50ms);
    EXPECT_TRUE(world->sink(1).congested());
  }
  time.run_for(1ms);
  EXPECT_FALSE(world->sink(1).congested());
  Client next(host, 19202);
  time.run_for(10ms);
  ASSERT_TRUE(next.stream->send(probe_of_sink()));
  time.run_for(500ms);
  EXPECT_EQ(next.frames, 2) << "the answers to its own frame alone";
}

TEST_F(MoteWorld, ListensAgainToWhomItHeldUpBeforeAReboot) {
  open(plain(), "at 3s sink-reboot 1");
  Client client(host, 19202);
  time.run_for(2900ms);
  for (int i = 0; i < 1500; ++i) ASSERT_TRUE(client.stream->send(probe_of_sink()));
  time.run_for(50ms);
  ASSERT_TRUE(world->sink(1).congested());
  time.run_for(100ms);
  EXPECT_FALSE(world->sink(1).congested());
  time.run_for(30s);
  const auto frames = client.frames;
  ASSERT_TRUE(client.stream->send(probe_of_sink()));
  time.run_for(1s);
  EXPECT_EQ(client.frames, frames + 2);
}

TEST_F(MoteWorld, KeepsNothingForAComputerThatDoesNotRead) {
  open(plain());
  Client client(host, 19202);
  time.run_for(2s);
  const auto record = hex("01 0003 0400");
  ASSERT_TRUE(client.stream->send(motes::hdlc_acked_packet(1, motes::packet_of(command(2, record)))));
  time.run_for(3s);
  client.stream->hold(true);
  time.run_for(60s);
  const auto frames = client.frames;
  client.stream->hold(false);
  time.run_for(100ms);
  EXPECT_LE(client.frames, frames + 2) << "one that was under way, and one of now, but none of a minute";
  time.run_for(10s);
  EXPECT_GE(client.frames, frames + 10);
}

TEST_F(MoteWorld, OpensAPortAgainThatTheSystemTookAway) {
  make(plain(), "", false);
  ASSERT_TRUE(world->open(1, on_tcp(host, {"127.0.0.1", 19202})));
  Client first(host, 19202);
  time.run_for(1s);
  net.tcp.deafen();
  time.run_for(100ms);
  EXPECT_TRUE(world->port(1).pulled());
  EXPECT_EQ(first.failed, 0) << "who is there stays";
  time.run_for(2s);
  EXPECT_FALSE(world->port(1).pulled());
  first.stream.reset();
  time.run_for(1s);
  const Client second(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(second.connected, 1);
  EXPECT_EQ(second.failed, 0);
  EXPECT_EQ(count("sink-boot"), 0u);
}

TEST_F(MoteWorld, UnpluggedTwiceItHasNoPowerUntilTheLaterEnd) {
  open(plain(), "at 1s unplug 1 for 10s\nat 2s unplug 1 for 1s\nat 4s sink-reboot 1");
  time.run_for(10s);
  EXPECT_TRUE(world->port(1).pulled());
  EXPECT_EQ(count("sink-boot"), 0u) << "without power there is nothing to reboot";
  time.run_for(2s);
  EXPECT_FALSE(world->port(1).pulled());
  EXPECT_EQ(count("sink-boot"), 1u);
}

TEST_F(MoteWorld, UnpluggedASinkIsGoneAndComesBackOnItsCompiledIsland) {
  open(plain(), "at 5s unplug 1 for 5s");
  Client client(host, 19202);
  time.run_for(1s);
  ASSERT_TRUE(client.stream->send(motes::hdlc_acked_packet(
      1, motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, 42})))));
  time.run_for(1s);
  EXPECT_EQ(world->sink(1).island(), 42);
  time.run_for(4s);
  EXPECT_EQ(client.failed, 1);
  const Client early(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(early.failed, 1);
  time.run_for(4s);
  EXPECT_EQ(world->sink(1).island(), 11);
  const Client late(host, 19202);
  time.run_for(1s);
  EXPECT_EQ(late.connected, 1);
  EXPECT_EQ(late.failed, 0);
}

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

TEST_F(MoteWorld, StepsAboutWhatIsNotThereDoNothing) {
  make(plain(),
       "at 0s kill 99\nat 0s reboot 5@9\nat 0s unplug 9 for 1s\nat 0s sink-reboot 9\nat 0s move 2 to 9\nat 0s set 99 "
       "light 1");
  time.run_for(5s);
  EXPECT_EQ(count("off"), 0u);
  EXPECT_THAT(world->radio().cells(world->mote(2).node()), ElementsAre(1)) << "not in no cell";
}

TEST(MoteScriptInAWorld, IsCheckedForMotesAndSinksThatAreNotThere) {
  WorldOptions world;
  world.sinks = 2;
  world.add_motes(1, 2, 3);
  world.add_motes(2, 7, 1);
  const auto said = [&](std::string_view script) {
    const auto checked = check_script(*parse_script(script), world);
    return checked ? std::string("good") : checked.error().text;
  };
  for (const auto* good : {"at 1s kill 4", "at 1s kill 7@2", "at 1s set all light 1", "at 1s move 4 to 1,2",
                           "at 1s move 4 to none", "at 1s sink-reboot 2", "at 1s loss 5"})
    EXPECT_EQ(said(good), "good") << good;
  EXPECT_EQ(said("at 2s loss 1\n\nat 1s kill 99"), "line 3: there is no mote 99, expected one of 2 to 7");
  EXPECT_EQ(said("at 1s loss 5 of 7@1"), "line 1: there is no mote 7@1, expected one of 2 to 7");
  EXPECT_EQ(said("at 1s move 4 to 2,3"), "line 1: there is no sink 3, expected 1 to 2");
  EXPECT_EQ(said("at 1s sink-reboot 3"), "line 1: there is no sink 3, expected 1 to 2");
  EXPECT_EQ(said("at 1s unplug 3 for 1s"), "line 1: there is no sink 3, expected 1 to 2");
}

TEST_F(MoteWorld, LosesAndDoublesRadioMessagesAsToldTo) {
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

TEST_F(MoteWorld, DelaysRadioMessagesAsToldTo) {
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

/// Counts what somebody has the scheduler do.
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
}  // namespace rubicon::mote_simulator
