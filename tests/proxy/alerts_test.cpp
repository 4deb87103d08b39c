#include "proxy/alerts.h"

#include "commands.h"

namespace rubicon::proxy {
namespace {

class ProxyAlerts : public Commands {
 protected:
  model::AlertList alerts() const {
    model::AlertList list;
    proxy->add_alerts(list);
    return list;
  }
  std::vector<std::string> kinds() const {
    std::vector<std::string> kinds;
    for (const auto& one : alerts().all) kinds.push_back(one.kind + " " + one.about);
    return kinds;
  }
};

using Kinds = std::vector<std::string>;

TEST_F(ProxyAlerts, NoneWhileAllIsWell) {
  begin();
  report("7", sensor(kGlow), 1.5);
  EXPECT_EQ(alerts(), model::AlertList());
}

TEST_F(ProxyAlerts, ASilentDeviceIsOneUntilItIsHeard) {
  begin();
  time.run_for(61s);
  ASSERT_EQ(kinds(), Kinds{"device-silent proxy.hall.7"});
  const auto one = alerts().all[0];
  EXPECT_EQ(one.severity, model::Severity::kWarning);
  EXPECT_EQ(base::to_seconds(one.since), json("proxy.hall.7.status")["since"].get<double>());
  EXPECT_THAT(one.what, ::testing::HasSubstr("hall.7) is not reachable: "));
  report("7", sensor(kGlow), 1.5);
  EXPECT_EQ(kinds(), Kinds());
}

TEST_F(ProxyAlerts, ADeviceThatItsNetworkCannotUseNamesAnotherRemedy) {
  begin();
  say("7", model::Unreachable{"gone"});
  EXPECT_THAT(alerts().all.at(0).fix, ::testing::HasSubstr("check its power or battery"));
  auto device = lamp();
  device.problem = "interview failed";
  join("7", device);
  ASSERT_EQ(kinds(), Kinds{"device-silent proxy.hall.7"});
  EXPECT_THAT(alerts().all[0].what, ::testing::HasSubstr("interview failed"));
  EXPECT_EQ(alerts().all[0].fix, "change what the reason names");
}

TEST_F(ProxyAlerts, ARecordingThatIsAtItsEndIsNone) {
  begin();
  say("", model::State{model::LineState::kEnded, "end of file", {}});
  EXPECT_EQ(kinds(), Kinds());
}

TEST_F(ProxyAlerts, ALineThatIsDownStandsForItsDevices) {
  begin();
  say("7", model::Unreachable{"gone"});
  hall().lose_line();
  time.run_for(1s);
  ASSERT_EQ(kinds(), Kinds{"line-down proxy.hall"});
  EXPECT_EQ(alerts().all[0].severity, model::Severity::kProblem);
  EXPECT_THAT(alerts().all[0].what, ::testing::HasSubstr("network hall is down: no carrier"));
  EXPECT_THAT(alerts().all[0].fix, ::testing::HasSubstr("networks: hall:"));
}

TEST_F(ProxyAlerts, ACommandThatFailedIsOneUntilTheNextOrForADay) {
  begin();
  hall().outcome = Outcome::kFailed;
  hall().why = "no acknowledgement";
  set(kFlapPoint + ".command", "open");
  ASSERT_EQ(kinds(), Kinds{"command-failed " + kFlapPoint});
  EXPECT_THAT(alerts().all[0].what, ::testing::HasSubstr("flap-1 = 'open' failed: no acknowledgement"));
  hall().outcome = Outcome::kSent;
  set(kFlapPoint + ".command", "shut");
  EXPECT_EQ(kinds(), Kinds());
  report("7", actuator(kFlap), false);
  hall().outcome = Outcome::kFailed;
  set(kFlapPoint + ".command", "open");
  EXPECT_EQ(kinds().size(), 1U);
  for (int i = 0; i < 25 * 60; ++i) {
    time.run_for(1min);
    report("7", sensor(kGlow), 1.5);
  }
  EXPECT_EQ(kinds(), Kinds());
}

TEST_F(ProxyAlerts, ARefusedCommandIsThatOfItsUserAlone) {
  begin();
  set(kFlapPoint + ".command", "ajar");
  EXPECT_EQ(kinds(), Kinds());
}

TEST_F(ProxyAlerts, BatteriesAreLowByChargeFlagOrWord) {
  start();
  auto device = lamp();
  for (const auto* name : {"battery", "batteryLow", "batteryState"})
    device.capabilities.push_back(capability(Kind::kSensor, types.find(name)->id));
  join("7", device);
  const auto tell = [this](const char* name, Value value) {
    report("7", sensor(types.find(name)->id), std::move(value));
  };
  const std::string points = "battery-low proxy.hall.7.sensor.";
  tell("battery", 15.0);
  tell("batteryLow", false);
  tell("batteryState", "medium");
  EXPECT_EQ(kinds(), Kinds());
  tell("battery", 14.0);
  EXPECT_EQ(kinds(), Kinds{points + "battery-1"});
  EXPECT_THAT(alerts().all[0].what, ::testing::HasSubstr("the battery is at 14 %"));
  tell("batteryLow", true);
  tell("batteryState", "low");
  EXPECT_EQ(kinds(), (Kinds{points + "battery-1", points + "batteryLow-1", points + "batteryState-1"}));
  tell("battery", 100.0);
  tell("batteryLow", false);
  tell("batteryState", "high");
  EXPECT_EQ(kinds(), Kinds());
}

TEST_F(ProxyAlerts, AThousandSilentDevicesAreCountedAndALineStaysFirst) {
  config.networks["attic"];
  begin();
  for (int i = 0; i < 1000; ++i) join("n" + std::to_string(i), lamp());
  say("7", model::Unreachable{"gone"});
  time.run_for(61s);
  const auto list = alerts();
  EXPECT_EQ(list.all.size(), model::AlertList::kMaxAlerts);
  EXPECT_EQ(list.more, 801U);
}

}  // namespace
}  // namespace rubicon::proxy
