#include <gmock/gmock.h>

#include "scenarios/roaming.h"

namespace rubicon::scenarios {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kSwitch = "proxy.scripted-1.7.actuator.switch-1";

/// A robot whose command waits for a silent device.
class RoamingCommands : public Roaming {
 protected:
  void begin(const std::string& more_of_2 = kLab) {
    start_island(1, kLab);
    start_island(2, more_of_2);
    join(1);
    scheduler.run_for(61s);
    statuses =
        component(70001).subscribe({std::nullopt, kSwitch + ".status"}, {.passive = true}, [this](const Event& event) {
          const auto text = std::string(event.tuple.value);
          if (event.kind == EventKind::kSet) last[number(event.tuple.owner)] = text;
        });
  }
  std::uint64_t set(const std::string& value, Duration time_to_live) {
    const auto request = component(70001).set_remote(OwnerId(1), kSwitch + ".command", value, time_to_live,
                                                     [this](const tuples::Reply& reply) { answer = reply; });
    scheduler.run_ready();
    EXPECT_EQ(answer.verdict, tuples::Verdict::kApplied) << answer.text;
    return request;
  }
  nlohmann::json command(std::uint32_t island) {
    return nlohmann::json::parse(last[island], nullptr, false).value("command", nlohmann::json());
  }
  std::map<std::uint32_t, std::string> last;
  tuples::Reply answer;
  Handle statuses;
};

TEST_F(RoamingCommands, AQueuedCommandFollowsAndTheCommanderReadsItsOutcome) {
  begin();
  set("off", 60s);
  const auto request = set("on", 60s);
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).commands, IsEmpty());
  EXPECT_THAT(devices_of(2).commands, ElementsAre(std::pair(std::string("7"), Value(true)))) << "once, the newest";
  devices_of(2).say("7", reading(actuator("switch"), true));
  scheduler.run_for(1s);
  EXPECT_EQ(command(2)["state"], "confirmed");
  EXPECT_EQ(command(2)["creator"], 70001);
  EXPECT_EQ(command(2)["request"], request);
  EXPECT_EQ(value(islands[2]->space(), 2, kSwitch + ".command"), "on");
  join(1);
  scheduler.run_for(60s);
  EXPECT_THAT(devices_of(1).commands, IsEmpty()) << "never executed again";
  EXPECT_THAT(devices_of(2).commands, SizeIs(1));
}

TEST_F(RoamingCommands, TheTimeToLiveGoesOnWhereItGoes) {
  begin();
  set("on", 10s);
  scheduler.run_for(5s);
  join(2);
  scheduler.run_for(100ms);
  devices_of(2).cable = false;
  devices_of(2).lose_line();
  scheduler.run_for(4800ms);
  EXPECT_EQ(command(2)["state"], "queued");
  scheduler.run_for(200ms);
  EXPECT_EQ(command(2)["state"], "expired");
  devices_of(2).cable = true;
  scheduler.run_for(60s);
  EXPECT_THAT(devices_of(2).commands, IsEmpty());
}

TEST_F(RoamingCommands, WhatTheNewIslandRefusesIsShownAsFailed) {
  begin();
  set("on", 60s);
  model::Join less;
  less.capabilities = {capability(sensor("light"))};
  devices_of(2).say("7", less);
  scheduler.run_for(1s);
  EXPECT_EQ(command(1)["state"], "failed");
  EXPECT_FALSE(command(1).contains("until")) << "it is final";
  EXPECT_EQ(command(1)["creator"], 70001);
  EXPECT_THAT(std::string(command(1)["reason"]), HasSubstr("moved to island 2"));
  EXPECT_EQ(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
  scheduler.run_for(11s);
  EXPECT_EQ(value(islands[1]->space(), 1, kSwitch + ".status"), "(none)");
}

TEST_F(RoamingCommands, TheLastWordsDoNotStandInTheWayOfItsReturn) {
  begin();
  set("on", 60s);
  model::Join less;
  less.capabilities = {capability(sensor("light"))};
  devices_of(2).say("7", less);
  scheduler.run_for(2s);
  join(1);
  scheduler.run_for(30s);
  EXPECT_EQ(json(islands[1]->space(), 1, kSwitch + ".status")["quality"], "unknown");
  EXPECT_FALSE(json(islands[1]->space(), 1, kSwitch + ".status").contains("command"));
}

TEST_F(RoamingCommands, ANewerCommandAtTheNewIslandIsNotUndone) {
  begin();
  set("off", 60s);
  ecology.cut(OwnerId(1), OwnerId(2));
  join(2);
  scheduler.run_for(1s);
  component(70001).set_remote(OwnerId(2), kSwitch + ".command", "on", 5s, nullptr);
  scheduler.run_for(1s);
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(10s);
  EXPECT_THAT(devices_of(2).commands, ElementsAre(std::pair(std::string("7"), Value(true))));
  EXPECT_EQ(command(1)["state"], "failed");
  EXPECT_THAT(std::string(command(1)["reason"]), HasSubstr("newer command"));
}

TEST_F(RoamingCommands, ANewerCommandThatIsCarriedOutAlreadyIsNotUndoneEither) {
  begin();
  set("off", 60s);
  ecology.cut(OwnerId(1), OwnerId(2));
  join(2);
  scheduler.run_for(1s);
  component(70001).set_remote(OwnerId(2), kSwitch + ".command", "on", 5s, nullptr);
  scheduler.run_for(1s);
  devices_of(2).say("7", reading(actuator("switch"), true));
  scheduler.run_for(1s);
  ASSERT_EQ(command(2)["state"], "confirmed");
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(10s);
  EXPECT_THAT(devices_of(2).commands, ElementsAre(std::pair(std::string("7"), Value(true))));
  EXPECT_EQ(command(1)["state"], "failed");
}

TEST_F(RoamingCommands, TheRateThatAUserSetGoesWithTheDeviceAndBack) {
  const auto kRate = std::string("proxy.scripted-1.7.property.rate");
  const auto join_with_rate = [&](std::uint32_t island) {
    auto join = lamp();
    join.capabilities.push_back(capability(point(Kind::kProperty, "rate", ""), Access::kReadWrite));
    devices_of(island).say("7", join);
    scheduler.run_for(2s);
  };
  const auto rate = [&](std::uint32_t island) { return value(islands[island]->space(), island, kRate + ".value"); };
  start_island(1, kLab);
  start_island(2, kLab);
  join_with_rate(1);
  join_with_rate(2);
  EXPECT_EQ(rate(2), "1000") << "nobody set it";
  component(70001).set_remote(OwnerId(2), kRate + ".command", "5000", 5s, nullptr);
  scheduler.run_for(1s);
  ASSERT_EQ(rate(2), "5000");
  for (const auto island : {1U, 2U, 1U}) {
    join_with_rate(island);
    EXPECT_EQ(rate(island), "5000") << "at island " << island;
  }
  component(70001).set_remote(OwnerId(1), kRate + ".command", "300", 5s, nullptr);
  scheduler.run_for(1s);
  join_with_rate(2);
  EXPECT_EQ(rate(2), "300") << "the newest";
}

TEST_F(RoamingCommands, TheRateOfANetworkStaysWithIt) {
  const auto kRate = std::string("proxy.scripted-1.7.property.rate.value");
  start_island(1, kLab);
  start_island(2, "roaming: lab, rate: 3s");
  auto join = lamp();
  join.capabilities.push_back(capability(point(Kind::kProperty, "rate", ""), Access::kReadWrite));
  for (const auto island : {1U, 2U}) {
    devices_of(island).say("7", join);
    scheduler.run_for(2s);
  }
  EXPECT_EQ(value(islands[2]->space(), 2, kRate), "3000");
}

TEST_F(RoamingCommands, OnlyAnIslandThatListedTheDeviceTransfersCommands) {
  begin();
  join(2);
  scheduler.run_for(1s);
  const auto text = R"({"kind":"actuator","type":)" + std::to_string(static_cast<unsigned>(actuator("switch").type)) +
                    R"(,"instance":"1","value":"off","creator":1,"request":1})";
  const auto reply_to = [&](std::uint32_t from) {
    tuples::Reply reply;
    auto& space = from == 1 ? islands[1]->space() : component(from);
    space.set_remote(OwnerId(2), "ROAMING.lab.7", text, 5s, [&](const tuples::Reply& got) { reply = got; });
    scheduler.run_for(1s);
    return reply.verdict;
  };
  EXPECT_EQ(reply_to(77), tuples::Verdict::kRefused);
  EXPECT_EQ(reply_to(70005), tuples::Verdict::kRefused);
  EXPECT_THAT(devices_of(2).commands, IsEmpty());
  EXPECT_EQ(reply_to(1), tuples::Verdict::kApplied);
  EXPECT_THAT(devices_of(2).commands, SizeIs(1));
}

}  // namespace
}  // namespace rubicon::scenarios
