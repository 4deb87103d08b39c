#include "device_support.h"
#include "networks/zigbee/device/commands.h"

namespace rubicon::networks::zigbee {
namespace {

using Texts = std::vector<std::string>;

/// What a command is taken for when an answer is lost, or comes where copies are expected.
class LostAnswers : public DeviceTest {};

TEST_F(LostAnswers, AnAcknowledgementThatWasLostSwallowsNoProofLater) {
  start(record_of(definitions::kPlug));
  report(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  echo(R"("state":"ON","power":0)");
  run(milliseconds(3010));  // the device answered nothing, not even the set
  ASSERT_EQ(gets().size(), 3U);
  report(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST(CommandsOfADevice, ALevelDoesNotSupersedeAStepOfTheSameProperty) {
  base::VirtualScheduler time;
  std::vector<std::string> published, answered;
  device::Commands commands(time, {[&](std::string payload) {
                                     published.push_back(std::move(payload));
                                     return Result<void>();
                                   },
                                   [&](std::uint64_t request, model::Outcome, const std::string& text) {
                                     answered.push_back(std::to_string(request) + " " + text);
                                   },
                                   [](const device::Command&) {}});
  const auto add = [&](std::uint64_t request, const std::string& json, bool event) {
    device::Command command;
    command.request = request;
    command.key = "position";
    command.json = json;
    command.event = event;
    EXPECT_TRUE(commands.add(command, false, Duration(0)));
  };
  add(1, "\"STOP\"", true);
  add(2, "50", false);
  add(3, "60", false);
  time.run_ready();
  EXPECT_EQ(published, (std::vector<std::string>{R"({"position":"STOP"})", R"({"position":60})"}));
  EXPECT_EQ(answered, std::vector<std::string>{"2 superseded by a newer command"});
}

TEST_F(LostAnswers, WithoutLastSeenTheAnswerToOurGetIsTheProofAlsoSoonAfterTheStart) {
  start(record_of(definitions::kPlug), false);
  device->line_up();
  run(seconds(1));
  say_plain(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  say_plain(R"("state":"ON","power":0)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  run(milliseconds(300));
  EXPECT_TRUE(readings().empty());
  say_plain(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(LostAnswers, WhereNoEchoesComeWhatIsSaidSoonAfterTheStartIsACopyThoughTheDeviceWasAsked) {
  start(record_of(definitions::kPlug), false);
  device->optimistic(false);
  device->line_up();
  run(seconds(1));
  forget();
  commanded("state", true);
  run(milliseconds(310));
  ASSERT_EQ(gets(), Texts{R"({"state":""})"});
  say_plain(R"("state":"OFF")");
  EXPECT_TRUE(readings().empty());
  EXPECT_EQ(readings(false), (Values{{"state", "off"}}));
}

TEST_F(LostAnswers, WithoutLastSeenTheAnswerOfADeviceThatDidNotObeyIsAReportAlsoSoonAfterTheStart) {
  start(record_of(definitions::kPlug), false);
  device->line_up();
  run(seconds(1));
  say_plain(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  say_plain(R"("state":"ON","power":0)");
  run(milliseconds(300));
  say_plain(R"("state":"OFF","power":0)");
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
  forget();
  sample({"state"}, milliseconds(1000));
  run(milliseconds(800));
  ASSERT_GE(gets().size(), 1U) << "it is asked again, because it may obey late";
  say_plain(R"("state":"OFF","power":0)");
  EXPECT_EQ(readings(), (Values{{"state", "off"}})) << "the same answer is news of its time";
}

}  // namespace
}  // namespace rubicon::networks::zigbee
