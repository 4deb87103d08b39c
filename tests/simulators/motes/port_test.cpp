#include <gmock/gmock.h>

#include "simulators/motes/simulated_world.h"

namespace rubicon::motes_simulator {
namespace {

class SinkPorts : public SimulatedWorld {};

TEST_F(SinkPorts, SpeaksOverAPortToOneComputerAtATime) {
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

TEST_F(SinkPorts, RunsOnWithoutAComputerAndItsBytesAreLost) {
  open(plain());
  time.run_for(5s);
  EXPECT_TRUE(world->mote(2).joined());
  const Client late(host, 19202);
  time.run_for(1min);
  EXPECT_EQ(late.all, 0u);
}

TEST_F(SinkPorts, BootsItsMotesAfterTheFirstConnectionIfItWaits) {
  auto options = plain();
  options.wait_for_computer = true;
  open(std::move(options));
  time.run_for(1min);
  EXPECT_FALSE(world->mote(2).on());
  const Client client(host, 19202);
  time.run_for(2s);
  EXPECT_EQ(client.frames, 2);
}

TEST_F(SinkPorts, HoldsUpAComputerThatSendsFasterThanTheLine) {
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

TEST_F(SinkPorts, HoldsUpGarbageLikeFramesAndHearsWhatComesBehindIt) {
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

TEST_F(SinkPorts, ForgetsWhatIsNotOnTheLineYetWhenTheComputerHangsUp) {
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

TEST_F(SinkPorts, ReadsFromAHeldComputerAgainAfterAReboot) {
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

TEST_F(SinkPorts, KeepsNothingForAComputerThatDoesNotRead) {
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

TEST_F(SinkPorts, OpensAPortAgainThatTheSystemTookAway) {
  make(plain(), "", false);
  ASSERT_TRUE(world->open(1, on_tcp(host, {"127.0.0.1", 19202})));
  Client first(host, 19202);
  time.run_for(1s);
  net.tcp.fail_listeners();
  time.run_for(100ms);
  EXPECT_TRUE(world->port(1).pulled());
  EXPECT_EQ(first.failed, 0) << "the connected computer stays";
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

TEST_F(SinkPorts, UnpluggedTwiceItHasNoPowerUntilTheLaterEnd) {
  open(plain(), "at 1s unplug 1 for 10s\nat 2s unplug 1 for 1s\nat 4s sink-reboot 1");
  time.run_for(10s);
  EXPECT_TRUE(world->port(1).pulled());
  EXPECT_EQ(count("sink-boot"), 0u) << "without power there is nothing to reboot";
  time.run_for(2s);
  EXPECT_FALSE(world->port(1).pulled());
  EXPECT_EQ(count("sink-boot"), 1u);
}

TEST_F(SinkPorts, UnpluggedASinkIsGoneAndComesBackOnItsCompiledIsland) {
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

}  // namespace
}  // namespace rubicon::motes_simulator
