#include <gmock/gmock.h>

#include "scenarios/ecology.h"

namespace rubicon::scenarios {
namespace {

using testing::HasSubstr;

/// An island with one line, and a component that opens it.
class LineOfANetwork : public Ecology {
 protected:
  void SetUp() override {
    start_island(1);
    viewer = &component(70001);
    everything = viewer->subscribe({OwnerId(1), "**"}, {.passive = true}, [](const Event&) {});
    scheduler.run_for(1s);
  }
  /// Without a cable until the pause between two attempts is some seconds long.
  void lose_line() {
    devices_of(1).cable = false;
    devices_of(1).lose_line();
    scheduler.run_for(1min);
    ASSERT_EQ(line(), "down");
  }
  tuples::Reply command(std::string_view text, Duration time = 10ms) {
    tuples::Reply got;
    viewer->set_remote(OwnerId(1), std::string(kLine) + ".command", text, 5s,
                       [&](const tuples::Reply& reply) { got = reply; });
    scheduler.run_for(time);
    return got;
  }
  nlohmann::json outcome() { return json(*viewer, 1, std::string(kLine) + ".status")["command"]; }
  std::string line() { return value(*viewer, 1, std::string(kLine) + ".value"); }

  static constexpr const char* kLine = "proxy.scripted-1.property.line";
  TupleSpace* viewer = nullptr;
  Handle everything;
};

TEST_F(LineOfANetwork, DescribesItsCommand) {
  const auto about = json(*viewer, 1, std::string(kLine) + ".description");
  EXPECT_EQ(about["words"], nlohmann::json({"reopen"}));
  EXPECT_EQ(about["access"], "write");
  EXPECT_EQ(json(*viewer, 1, std::string(kLine) + ".status"), nlohmann::json::object());
}

TEST_F(LineOfANetwork, IsOpenedAtOnceWhereItWouldWait) {
  lose_line();
  devices_of(1).cable = true;
  EXPECT_EQ(command("reopen").verdict, tuples::Verdict::kApplied);
  EXPECT_EQ(line(), "up");
  EXPECT_EQ(outcome()["state"], "confirmed");
}

TEST_F(LineOfANetwork, AnAttemptThatFailsHasTheReasonAndTheNextOneComesSoon) {
  lose_line();
  command("reopen");
  EXPECT_EQ(outcome()["state"], "failed");
  EXPECT_EQ(outcome()["reason"], "no carrier");
  devices_of(1).cable = true;
  scheduler.run_for(200ms);
  EXPECT_EQ(line(), "up") << "after the shortest pause";
}

TEST_F(LineOfANetwork, OneThatIsUpIsNotTouched) {
  EXPECT_EQ(command("reopen").verdict, tuples::Verdict::kApplied);
  EXPECT_EQ(outcome()["state"], "refused");
  EXPECT_EQ(outcome()["reason"], "the line is up");
  const auto other = command("close");
  EXPECT_EQ(other.verdict, tuples::Verdict::kRefused);
  EXPECT_THAT(other.text, HasSubstr("expected reopen"));
}

TEST_F(LineOfANetwork, OneThatIsBeingOpenedIsNotOpenedTwice) {
  lose_line();
  devices_of(1).silent = true;
  command("reopen");
  EXPECT_EQ(outcome()["state"], "sent");
  EXPECT_GT(outcome()["until"], 0);
  const auto first = outcome();
  const auto second = command("reopen");
  EXPECT_EQ(second.verdict, tuples::Verdict::kRefused);
  EXPECT_EQ(second.code, ErrorCode::kBusy);
  EXPECT_THAT(second.text, HasSubstr("is under way"));
  EXPECT_EQ(outcome(), first) << "the second one must not take the outcome from the first";
  devices_of(1).host().failed({ErrorCode::kIo, "no answer"});
  scheduler.run_ready();
  EXPECT_EQ(outcome()["state"], "failed");
  EXPECT_EQ(outcome()["reason"], "no answer");
  EXPECT_EQ(outcome()["request"], first["request"]);
}

TEST_F(LineOfANetwork, OfTwoInOneTurnOneIsCarriedOut) {
  lose_line();
  devices_of(1).silent = true;
  command("reopen", 0ms);
  EXPECT_EQ(command("reopen").code, ErrorCode::kBusy);
  EXPECT_EQ(outcome()["state"], "sent");
}

TEST_F(LineOfANetwork, AfterAnAttemptThatFailedTheNextOneMayBegin) {
  lose_line();
  EXPECT_EQ(command("reopen").verdict, tuples::Verdict::kApplied);
  EXPECT_EQ(outcome()["state"], "failed");
  devices_of(1).cable = true;
  EXPECT_EQ(command("reopen").verdict, tuples::Verdict::kApplied);
  EXPECT_EQ(outcome()["state"], "confirmed");
}

TEST_F(LineOfANetwork, OneThatStaysSilentIsSentThenTimedOut) {
  lose_line();
  devices_of(1).silent = true;
  command("reopen");
  scheduler.run_for(29s);
  EXPECT_EQ(outcome()["state"], "sent");
  scheduler.run_for(2s);
  EXPECT_EQ(outcome()["state"], "timed-out");
  devices_of(1).say("", model::State{model::LineState::kUp, {}, {}});
  scheduler.run_for(1s);
  EXPECT_EQ(outcome()["state"], "timed-out");
}

TEST_F(LineOfANetwork, ItsCommandGoesWithTheNetwork) {
  const auto tree = config::parse_yaml("island: {id: 1, name: test}\n", "island.yaml");
  base::ConfigErrors errors;
  auto without = island::read_island_config(tree.value(), std::span(&kScripted, 1), errors);
  ASSERT_TRUE(islands.at(1)->reload(std::move(without), errors)) << errors.text();
  scheduler.run_for(1s);
  EXPECT_EQ(value(*viewer, 1, std::string(kLine) + ".command"), "(none)");
  EXPECT_EQ(value(*viewer, 1, std::string(kLine) + ".description"), "(none)");
}

}  // namespace
}  // namespace rubicon::scenarios
