#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <thread>

#include "apps/rubicon/live_island.h"
#include "support/mosquitto.h"
#include "support/programs.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

TEST(ZigbeeTool, KnowsItsSubcommands) {
  EXPECT_THAT(rubicon({"zigbee", "--help"}).output, HasSubstr("permit"));
  EXPECT_EQ(rubicon({"zigbee"}).code, 2);
  EXPECT_THAT(rubicon({"complete", "--", "zigbee", "per"}).output, HasSubstr("permit"));
  EXPECT_THAT(rubicon({"manual"}).output, HasSubstr(".SS zigbee permit"));
}

/// An island on a mosquitto with a simulated Zigbee2MQTT.
class ZigbeeIsland : public testing::Test {
 protected:
  static constexpr std::string_view kDevices =
      "device lamp hall/lamp\n"
      "device thermometer attic\n"
      "group 7 lamps hall/lamp\n"
      "at 0s permit 200s\n"
      "at 1s fail plug\n";

  void SetUp() override {
    if (const auto why = support::Mosquitto::missing(); !why.empty()) GTEST_SKIP() << why;
    network_ = std::make_unique<PrivateNetwork>();
    if (!network_->entered()) GTEST_SKIP() << network_->reason();
    broker_ = std::make_unique<support::Mosquitto>();
    for (int i = 0; i < 2400 && !broker_->ready(); ++i) std::this_thread::sleep_for(25ms);
    bridge_ = std::make_unique<Process>(std::vector<std::string>{support::kZigbeeSimulator,
                                                                 folder_.write("zigbee.script", std::string(kDevices)),
                                                                 "--broker", "127.0.0.1:1883"});
    ASSERT_TRUE(bridge_->line());
    island_ = std::make_unique<Process>(std::vector<std::string>{
        kDaemon, "run",
        folder_.write(
            "island.yaml",
            "island: {id: 6541, name: home}\n"
            "networks:\n"
            "  zigbee-flat: {type: zigbee, broker: \"127.0.0.1:1883\", devices: {attic: {id: loft, name: Under "
            "the roof}}}\n")});
    ASSERT_TRUE(until_listed("group-7")) << island_->errors();
  }

  static std::vector<json> devices() { return lines_of(rubicon({"zigbee", "devices", "--json"})); }
  /// The device as `rubicon zigbee devices` lists it; null if it does not.
  static json device(const std::string& name) {
    for (const auto& one : devices()) {
      if (one.is_object() && (one.value("name", "") == name || one.value("address", "") == name)) return one;
    }
    return {};
  }
  static bool until_listed(const std::string& name) {
    for (int i = 0; i < 600; ++i) {
      if (!device(name).is_null()) return true;
      std::this_thread::sleep_for(100ms);
    }
    return false;
  }

  std::unique_ptr<PrivateNetwork> network_;
  Folder folder_;
  std::unique_ptr<support::Mosquitto> broker_;
  std::unique_ptr<Process> bridge_, island_;
};

TEST_F(ZigbeeIsland, CommandsAreConfirmedByTheDevice) {
  const auto set = rubicon({"set", "zigbee-flat.00124b0010000000.lamp-1", "on"});
  EXPECT_EQ(set.code, 0) << set.errors;
  EXPECT_THAT(set.output + set.errors, HasSubstr("confirmed"));
  EXPECT_EQ(rubicon({"get", "zigbee-flat.00124b0010000000.lamp-1"}).output, "on\n");
  const auto group = rubicon({"set", "zigbee-flat.group-7.lamp-1", "off"});
  EXPECT_THAT(group.output + group.errors, HasSubstr("assumed"));
}

TEST_F(ZigbeeIsland, DevicesAreListedRenamedAndRemoved) {
  const auto lamp = device("hall/lamp");
  EXPECT_EQ(lamp.value("address", ""), "00124b0010000000");
  EXPECT_EQ(lamp.value("role", ""), "router");
  EXPECT_THAT(rubicon({"zigbee", "devices"}).output, HasSubstr("attic"));

  const auto renamed = rubicon({"zigbee", "rename", "0x00124b0010000001", "cellar"});
  EXPECT_EQ(renamed.code, 0) << renamed.errors;
  EXPECT_TRUE(until_listed("cellar"));
  const auto taken = rubicon({"zigbee", "rename", "cellar", "hall/lamp"});
  EXPECT_EQ(taken.code, 4);
  EXPECT_THAT(taken.errors, HasSubstr("hall/lamp")) << "the bridge's own words";

  EXPECT_EQ(rubicon({"zigbee", "remove", "cellar"}).code, 0);
  for (int i = 0; i < 600 && !device("cellar").is_null(); ++i) std::this_thread::sleep_for(100ms);
  EXPECT_TRUE(device("cellar").is_null());
  const auto gone = rubicon({"zigbee", "remove", "cellar"});
  EXPECT_EQ(gone.code, 4);
  EXPECT_THAT(gone.errors, HasSubstr("no device 'cellar'"));
}

TEST_F(ZigbeeIsland, ADeviceHasItsNamesOfTheIslandToo) {
  for (const auto* name : {"loft", "Under the roof", "zigbee-flat.loft"}) {
    const auto shown = rubicon({"zigbee", "options", name});
    EXPECT_EQ(shown.code, 0) << shown.errors;
  }
  ASSERT_EQ(rubicon({"zigbee", "rename", "hall/lamp", "loft"}).code, 0);
  ASSERT_TRUE(until_listed("loft"));
  const auto two = rubicon({"zigbee", "remove", "loft"});
  EXPECT_EQ(two.code, 4);
  EXPECT_THAT(two.errors, HasSubstr("name the device by its address"));
  ASSERT_EQ(rubicon({"zigbee", "rename", "00124b0010000000", "hall/lamp"}).code, 0);
  const auto removed = rubicon({"zigbee", "remove", "Under the roof"});
  EXPECT_EQ(removed.code, 0) << removed.errors;
  EXPECT_THAT(removed.output, HasSubstr("00124b0010000001"));
}

TEST_F(ZigbeeIsland, AFailedInterviewStandsInTheListAndInTheInbox) {
  std::vector<json> all;
  const auto unusable = [&] {
    all = devices();
    return std::count_if(all.begin(), all.end(),
                         [](const auto& one) { return one.value("interview", "") == "failed"; });
  };
  for (int i = 0; i < 600 && unusable() == 0; ++i) std::this_thread::sleep_for(100ms);
  ASSERT_EQ(unusable(), 1);
  std::string inbox;
  for (int i = 0; i < 600 && inbox.find("interview") == inbox.npos; ++i) inbox = rubicon({"inbox"}).output;
  EXPECT_THAT(inbox, HasSubstr("interview"));
}

TEST_F(ZigbeeIsland, PermitShowsWhoJoinsAndClosesAtAnInterrupt) {
  Process permit({kProgram, "zigbee", "permit", "--for", "200s"});
  ASSERT_TRUE(permit.line_with("may join for 200 s"));
  broker_->publish("zigbee2mqtt/bridge/event",
                   R"({"type":"device_joined","data":{"friendly_name":"porch","ieee_address":"0x00124b00100000ff"}})");
  EXPECT_TRUE(permit.line_with("porch joined"));
  permit.signal(SIGINT);
  EXPECT_TRUE(permit.line_with("joining is closed"));
  EXPECT_EQ(permit.exit_code(), 0) << permit.errors();
  EXPECT_EQ(rubicon({"zigbee", "permit", "--for", "5min"}).code, 2) << "Zigbee2MQTT takes at most 254 s";
  const auto via = rubicon({"zigbee", "permit", "--via", "nowhere"});
  EXPECT_EQ(via.code, 4);
  EXPECT_THAT(via.errors, HasSubstr("nowhere"));
}

TEST_F(ZigbeeIsland, OptionsHealthAndMap) {
  const auto set = rubicon({"zigbee", "options", "attic", "temperature_calibration=-0.5", "--json"});
  ASSERT_EQ(set.code, 0) << set.errors;
  EXPECT_THAT(set.output, HasSubstr("-0.5"));
  const auto shown = rubicon({"zigbee", "options", "attic"});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  EXPECT_EQ(rubicon({"zigbee", "options", "attic", "nothing"}).code, 2);
  const auto health = rubicon({"zigbee", "health"});
  EXPECT_EQ(health.code, 0) << health.errors;
  EXPECT_THAT(health.output, HasSubstr("is healthy"));
  const auto map = rubicon({"zigbee", "map"});
  EXPECT_EQ(map.code, 0) << map.errors;
  EXPECT_THAT(map.output, HasSubstr("hall/lamp"));
}

TEST_F(ZigbeeIsland, WithoutTheBridgeToolsNameTheReason) {
  bridge_->signal(SIGTERM);
  bridge_->exit_code();
  Outcome outcome;
  for (int i = 0; i < 600 && outcome.code != 4; ++i) outcome = rubicon({"zigbee", "health"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.errors, HasSubstr("Zigbee2MQTT"));
}

}  // namespace
}  // namespace rubicon::cli
