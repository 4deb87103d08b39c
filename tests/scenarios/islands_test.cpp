#include "scenarios/ecology.h"

namespace rubicon::scenarios {
namespace {

using Islands = Ecology;

Message user_message(std::uint32_t to, const std::string& type, const std::string& text = "hello") {
  Message message;
  message.destination.island = OwnerId(to);
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{type, Bytes(bytes.begin(), bytes.end())};
  return message;
}

TEST_F(Islands, ACommandFromAnotherIslandReachesTheDevice) {
  auto& a = start_island(1);
  start_island(2);
  devices_of(2).say("7", lamp());
  scheduler.run_ready();
  tuples::Reply reply;
  a.space().set_remote(OwnerId(2), "proxy.scripted-1.7.actuator.switch-1.command", "on", {},
                       [&](const tuples::Reply& answer) { reply = answer; });
  scheduler.run_ready();
  EXPECT_EQ(reply.verdict, tuples::Verdict::kApplied) << reply.text;
  ASSERT_EQ(devices_of(2).commands.size(), 1U);
  EXPECT_EQ(devices_of(2).commands[0].second, Value(true));
}

TEST_F(Islands, ACommandToAnIslandThatIsNotThereIsAnswered) {
  auto& a = start_island(1);
  tuples::Reply reply;
  a.space().set_remote(OwnerId(9), "proxy.x.y.actuator.switch-1.command", "on", {},
                       [&](const tuples::Reply& answer) { reply = answer; });
  scheduler.run_for(10s);
  EXPECT_EQ(reply.verdict, tuples::Verdict::kNoSuchOwner);
}

TEST_F(Islands, DemandCrossesIslands) {
  auto& a = start_island(1);
  start_island(2);
  devices_of(2).say("7", lamp());
  std::vector<std::string> values;
  auto demand = a.space().subscribe({OwnerId(2), "proxy.*.*.sensor.temperature-1.value"}, {},
                                    [&](const Event& event) { values.emplace_back(event.tuple.value); });
  scheduler.run_ready();
  EXPECT_EQ(devices_of(2).sampled["7"].points, std::vector{sensor("temperature")});
  devices_of(2).say("7", reading(sensor("temperature"), 20.25));
  scheduler.run_ready();
  EXPECT_EQ(values.back(), "20.25");
  demand.reset();
  scheduler.run_ready();
  EXPECT_TRUE(devices_of(2).sampled["7"].points.empty());
}

TEST_F(Islands, AMessageOfADeviceReachesADeviceOfAnotherIsland) {
  start_island(1);
  start_island(2);
  Message message = user_message(2, "greeting");
  message.source.device = "3";
  message.destination.network = "scripted-1";
  message.destination.device = "4";
  devices_of(1).host().deliver(std::move(message));
  scheduler.run_ready();
  ASSERT_EQ(devices_of(2).sent.size(), 1U);
  const auto& got = devices_of(2).sent[0];
  EXPECT_EQ(got.source, (Address{OwnerId(1), "scripted-1", "3"}));
  EXPECT_EQ(got.destination.device, "4");
  EXPECT_EQ(base::as_text(std::get<model::Opaque>(got.body).bytes), "hello");
}

TEST_F(Islands, MessagesBetweenIslandsArriveOnceAndInOrder) {
  auto& a = start_island(1);
  auto& b = start_island(2);
  std::vector<std::string> got;
  auto listener = b.gateway().subscribe_user("count", [&](const Message& message) {
    got.emplace_back(base::as_text(std::get<model::Opaque>(message.body).bytes));
  });
  std::vector<std::string> expected;
  for (int i = 0; i < 500; ++i) {
    expected.push_back(std::to_string(i));
    a.gateway().send(user_message(2, "count", expected.back()));
    if (i % 7 == 0) scheduler.run_ready();
  }
  scheduler.run_for(1s);
  EXPECT_EQ(got, expected);
}

TEST_F(Islands, AnUndeliverableMessageIsAnsweredWithTheReason) {
  auto& a = start_island(1);
  start_island(2);
  std::vector<std::string> reasons;
  auto listener = a.gateway().subscribe(MessageKind::kAcknowledge, [&](const Message& message) {
    reasons.push_back(std::get<model::Acknowledge>(message.body).text);
  });
  a.gateway().send(user_message(9, "lost"));
  scheduler.run_for(10s);
  ASSERT_EQ(reasons.size(), 1U);
  EXPECT_NE(reasons[0].find("9"), std::string::npos) << reasons[0];
  a.gateway().send(user_message(2, "nobody-listens"));
  scheduler.run_for(10s);
  ASSERT_EQ(reasons.size(), 2U);
  EXPECT_NE(reasons[1].find("nobody-listens"), std::string::npos) << reasons[1];
}

TEST_F(Islands, InARingThatForwardsEverythingEachMessageArrivesOnce) {
  std::map<std::uint32_t, int> arrived;
  std::vector<Handle> listeners;
  for (std::uint32_t id = 1; id <= 3; ++id) start_island(id);
  for (std::uint32_t id = 1; id <= 3; ++id) {
    auto& gateway = islands[id]->gateway();
    listeners.push_back(gateway.subscribe_user("gossip", [&arrived, &gateway, id](const Message& message) {
      ++arrived[id];
      Message onward = message;
      onward.destination.island = OwnerId(id % 3 + 1);
      gateway.send(onward);
    }));
  }
  for (int i = 0; i < 20; ++i) islands[1]->gateway().send(user_message(2, "gossip", std::to_string(i)));
  scheduler.run_for(60s);
  EXPECT_EQ(arrived[2], 20);
  EXPECT_EQ(arrived[3], 20);
  EXPECT_EQ(arrived[1], 0) << "what an island sent itself does not come back to it";
}

TEST_F(Islands, AnIslandCutOffIsNoticedAndServedAgainAfterwards) {
  auto& a = start_island(1);
  start_island(2);
  devices_of(2).say("7", lamp());
  std::string last;
  auto demand = a.space().subscribe({OwnerId(2), "proxy.*.*.sensor.light-1.value"}, {},
                                    [&](const Event& event) { last = event.tuple.value; });
  scheduler.run_ready();
  ecology.cut(OwnerId(1), OwnerId(2));
  scheduler.run_ready();
  EXPECT_TRUE(devices_of(2).sampled["7"].points.empty()) << "nobody reachable listens";
  devices_of(2).say("7", reading(sensor("light"), 300.0));
  scheduler.run_for(5s);
  EXPECT_EQ(last, "");
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(1s);
  EXPECT_EQ(last, "300");
  EXPECT_EQ(devices_of(2).sampled["7"].points.size(), 1U);
}

}  // namespace
}  // namespace rubicon::scenarios
