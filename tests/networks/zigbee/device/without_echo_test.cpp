#include "device_support.h"
#include "networks/zigbee/device/commands.h"

namespace rubicon::networks::zigbee {
namespace {

using Texts = std::vector<std::string>;

class WithoutEcho : public DeviceTest {};

/// The broker answers set messages in their order, each once.
TEST_F(WithoutEcho, TheAnswerOfTheBrokerCounts) {
  start(record_of(definitions::kLamp));
  host.taken = {};
  const auto identify = std::string("identify");
  commanded("identify", identify);
  commanded("state", true);
  commanded("identify", identify);
  run(seconds(2));
  ASSERT_EQ(sets().size(), 3U);
  EXPECT_TRUE(answers().empty());
  device->not_taken("not authorised");
  EXPECT_EQ(answers(), Texts{"1 refused"});
  EXPECT_EQ(text_of_answer(1), "not authorised");
  device->taken();
  EXPECT_EQ(answers(), Texts{"1 refused"}) << "the lamp's state waits for its echo";
  device->taken();
  EXPECT_EQ(answers(), (Texts{"1 refused", "3 sent"}));
  device->taken();
  device->not_taken("an answer too many");
  EXPECT_EQ(answers(), (Texts{"1 refused", "3 sent"}));
}

TEST_F(WithoutEcho, ACommandThatTheBrokerDoesNotAnswerIsSentAfterTheTimeOfAnEcho) {
  start(record_of(definitions::kLamp));
  host.taken = {};
  commanded("identify", std::string("identify"));
  run(device::Commands::kEchoTime - milliseconds(100));
  EXPECT_TRUE(answers().empty());
  run(milliseconds(200));
  EXPECT_EQ(answers(), Texts{"1 sent"});
}

TEST_F(WithoutEcho, AfterANewConnectionTheBrokerAnswersNothingOfBefore) {
  start(record_of(definitions::kLamp));
  host.taken = {};
  commanded("identify", std::string("identify"));
  device->line_lost("the broker is gone");
  EXPECT_EQ(answers(), Texts{"1 undeliverable"});
  device->connected();
  device->line_up();
  commanded("identify", std::string("identify"));
  device->not_taken("not authorised");
  EXPECT_EQ(answers(), (Texts{"1 undeliverable", "2 refused"}));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
