#include "gateway/gateway.h"
#include "island.h"

namespace rubicon::proxy {
namespace {

const std::string kFlapActuator = "proxy.hall.7.actuator.flap-1";

/// Commands that come as messages: of island 2, of a component, of a device of an own network.
class CommandMessages : public Island {
 protected:
  void begin() {
    start();
    join("7", lamp());
    answers = abroad.subscribe(MessageKind::kAcknowledge, [this](const Message& message) {
      heard.push_back(std::get<Acknowledge>(message.body));
    });
  }
  void ask(model::Body body, const std::string& device = "7") {
    Message message;
    message.destination = {kIsland, "hall", device};
    message.body = std::move(body);
    abroad.send(std::move(message));
    time.run_ready();
  }
  void sleep() {
    time.run_for(61s);
    ASSERT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
  }
  nlohmann::json command() const { return json(kFlapActuator + ".status")["command"]; }
  std::vector<model::Actuate> actuated() { return hall().sent_bodies<model::Actuate>(); }

  std::unique_ptr<tuples::Link> other_link = *ecology.join(OwnerId{2});
  TupleSpace other{OwnerId{2}, time, *other_link};
  gateway::Gateway abroad{time, other, log};
  tuples::Handle answers;
  std::vector<Acknowledge> heard;
};

TEST_F(CommandMessages, GoThroughTheCommandDeskLikeAnyOther) {
  begin();
  ask(model::Actuate{5, actuator(kFlap), true});
  EXPECT_EQ(text(kFlapActuator + ".command"), "open");
  EXPECT_EQ(command()["state"], "sent");
  EXPECT_EQ(command()["creator"], 2);
  EXPECT_EQ(command()["request"], 5);
  EXPECT_EQ(command()["commander"], "island 2");
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command()["state"], "confirmed");
  EXPECT_TRUE(log.contain(kFlapActuator + " = 'open' by island 2, id 2: confirmed"));
  EXPECT_THAT(heard, ::testing::ElementsAre(::testing::FieldsAre(5u, Outcome::kSent, "")));
}

TEST_F(CommandMessages, ExpireAndSayWhy) {
  begin();
  sleep();
  ask(model::Actuate{5, actuator(kFlap), true, 2s});
  EXPECT_EQ(command()["state"], "queued");
  time.run_for(3s);
  EXPECT_EQ(command()["state"], "expired");
  say("7", model::KeepAlive{});
  EXPECT_TRUE(actuated().empty());
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].outcome, Outcome::kFailed);
  EXPECT_THAT(heard[0].text, ::testing::StartsWith("expired: not sent within 2 s"));
}

TEST_F(CommandMessages, AreSupersededByNewerCommandsAndSupersedeOlderOnes) {
  begin();
  sleep();
  ask(model::Actuate{5, actuator(kFlap), true});
  set(kFlapActuator + ".command", "shut");
  ask(model::Actuate{6, actuator(kFlap), true});
  say("7", model::KeepAlive{});
  ASSERT_EQ(actuated().size(), 1u);
  EXPECT_EQ(actuated()[0].value, Value(true));
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[0].request, 5u);
  EXPECT_EQ(heard[0].text, "superseded: by component 70001");
  EXPECT_EQ(heard[1].outcome, Outcome::kSent);
}

TEST_F(CommandMessages, AreRefusedWhereASetWouldBe) {
  begin();
  const std::tuple<model::Body, std::string, Outcome> wrong[] = {
      {model::Actuate{1, actuator(kFlap), std::int64_t{12}}, "7", Outcome::kRefused},
      {model::Actuate{1, actuator(kFlap), {}}, "7", Outcome::kRefused},
      {model::Actuate{1, actuator(kKnob), true}, "7", Outcome::kUndeliverable},
      {model::Actuate{1, actuator(kFlap), true}, "99", Outcome::kUndeliverable},
      {model::SetProperty{1, sensor(kGlow), 1.0}, "7", Outcome::kRefused}};
  for (const auto& [body, device, outcome] : wrong) {
    heard.clear();
    ask(body, device);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].outcome, outcome) << heard[0].text;
    EXPECT_FALSE(heard[0].text.empty());
  }
  EXPECT_TRUE(hall().sent_bodies<model::Actuate>().empty());
  EXPECT_TRUE(hall().sent_bodies<model::SetProperty>().empty());
}

TEST_F(CommandMessages, KeepTheOutcomeAndTheWordsOfTheNetwork) {
  begin();
  for (const auto outcome : {Outcome::kUnsupported, Outcome::kUndeliverable, Outcome::kFailed}) {
    heard.clear();
    hall().outcome = outcome;
    hall().why = "no flaps";
    ask(model::Actuate{5, actuator(kFlap), true});
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].outcome, outcome);
    EXPECT_THAT(heard[0].text, ::testing::HasSubstr("no flaps"));
  }
}

TEST_F(CommandMessages, OfADeviceOfThisIslandAreNamedWithIt) {
  begin();
  join("8", lamp());
  Message message;
  message.source = {kIsland, "hall", "8"};
  message.destination = {kIsland, "hall", "7"};
  message.body = model::Actuate{5, actuator(kFlap), true};
  gate->from_network("hall", std::move(message));
  time.run_ready();
  EXPECT_EQ(command()["commander"], "hall 8 of island 6541");
  EXPECT_EQ(actuated().size(), 1u);
}

TEST_F(CommandMessages, ThatWereRelayedAreThoseOfTheirOrigin) {
  begin();
  std::unique_ptr<tuples::Link> third = *ecology.join(OwnerId{3});
  TupleSpace away{OwnerId{3}, time, *third};
  gateway::Gateway relay(time, away, log);
  Message message;
  message.origin = OwnerId{2};
  message.number = 5;
  message.hops = 1;
  message.source.island = OwnerId{2};
  message.destination = {kIsland, "hall", "7"};
  message.body = model::Actuate{5, actuator(kFlap), true};
  relay.send(std::move(message));
  time.run_ready();
  EXPECT_EQ(command()["creator"], 2);
  EXPECT_THAT(heard, ::testing::ElementsAre(::testing::FieldsAre(5u, Outcome::kSent, "")));
}

TEST_F(CommandMessages, CannotSampleOrProbeBehindTheProxysBack) {
  begin();
  const auto sampled = hall().sent_bodies<model::Sample>().size();
  ask(model::Sample{5, {sensor(kGlow)}, 100ms});
  ask(model::Probe{lamp()});
  EXPECT_EQ(hall().sent_bodies<model::Sample>().size(), sampled);
  EXPECT_TRUE(hall().sent_bodies<model::Probe>().empty());
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[0].outcome, Outcome::kRefused);
  EXPECT_THAT(heard[0].text, ::testing::HasSubstr("subscribe"));
}

}  // namespace
}  // namespace rubicon::proxy
