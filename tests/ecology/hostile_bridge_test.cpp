#include "ecology/sites.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr long kMaxOfABridge = 64L * 1024;  ///< kilobytes

/// Whoever may write below the base topic of a bridge, and the island that reads it.
class HostileBridge : public SitesOfABroker {
 protected:
  /// Each line is a message.
  static void say(const std::string& topic, const std::string& lines) {
    const auto said =
        support::run_to_end({"mosquitto_pub", "-h", "127.0.0.1", "-r", "-l", "-t", "zigbee2mqtt/" + topic}, lines);
    EXPECT_EQ(said.code, 0) << said.errors;
  }
  static json device(const std::string& address, const std::string& name) {
    json state{{"type", "binary"}, {"name", "state"},  {"property", "state"},
               {"access", 7},      {"value_on", "ON"}, {"value_off", "OFF"}};
    json exposes = json::array({{{"type", "switch"}, {"features", json::array({state})}}});
    return {{"ieee_address", address},     {"type", "Router"},
            {"friendly_name", name},       {"supported", true},
            {"interview_completed", true}, {"definition", {{"model", "m"}, {"vendor", "v"}, {"exposes", exposes}}}};
  }
  /// Names that would lead elsewhere, and far more devices than there are.
  static std::string list() {
    auto devices = json::array({device("0x00124b0000000001", "plug"), device("0x00124b0000000002", "../dummy-1/hall"),
                                device("../dummy-1/hall", "hall"), device("hall", "proxy.dummy-1.hall"),
                                device("0x00124b0000000003", "bridge/request"), json(7), json::array()});
    for (int i = 0; i < 20'000; ++i) devices.push_back(device("0x" + std::to_string(i), "n" + std::to_string(i)));
    return devices.dump();
  }
};

TEST_F(HostileBridge, TouchesNoOtherNetworkOfTheIsland) {
  support::Mosquitto broker;
  ASSERT_TRUE(broker.comes_up());
  std::filesystem::create_directories(folder_ / "site1");
  const auto one =
      island(1, "{broker: \"127.0.0.1\", trust_broker: yes}", "  zigbee: {type: zigbee, broker: \"127.0.0.1\"}\n");
  const auto description = ask(*one, "get proxy.dummy-1.hall.description").value("value", "none");
  const auto before = one->resident_kilobytes();
  say("bridge/info", R"({"version":"2.1.0","config":{}})");
  say("bridge/state", R"({"state":"online"})");
  say("bridge/devices", list());
  ASSERT_TRUE(support::until(*one, "get proxy.zigbee.00124b0000000001.description", 60s, [](const json& tuple) {
    return tuple.value("ok", false);
  })) << one->errors();
  say("bridge/devices", std::string(200'000, '[') + "\n" + std::string(200'000, '{') + "\n\xff\xfe\n7\nnull");
  say("bridge/info", R"([{"version":{"version":[]}}])");
  std::string states = R"({"state":"ON","dummy-1":{"hall":"off"}})";
  for (int i = 0; i < 10'000; ++i)
    states += "\n{\"state\":" + std::to_string(i) + "e300,\"x" + std::to_string(i) + "\":[]}";
  for (const auto* topic : {"plug", "../dummy-1/hall", "bridge/response/device/remove", "hall/set", "a/b/c/d/e/f"})
    say(topic, states);
  EXPECT_TRUE(ask(*one, "set proxy.dummy-1.hall.actuator.switch-1.command on").value("ok", false)) << one->errors();
  EXPECT_TRUE(support::until(*one, "get proxy.dummy-1.hall.actuator.switch-1.value", 60s, [](const json& tuple) {
    return tuple.value("value", "") == "on";
  })) << one->errors();
  EXPECT_EQ(ask(*one, "get proxy.dummy-1.hall.description").value("value", ""), description);
  EXPECT_THAT(ask(*one, "get proxy.dummy-1.devices").dump(), AllOf(HasSubstr("hall"), Not(HasSubstr("124b"))));
  EXPECT_LT(one->resident_kilobytes() - before, kMaxOfABridge);
  one->write("quit\n");
  EXPECT_EQ(one->exit_code(), 0) << one->errors();
}

}  // namespace
}  // namespace rubicon::ecology
