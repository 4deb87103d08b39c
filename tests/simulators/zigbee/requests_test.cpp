#include "simulators/zigbee/simulated_bridge.h"

namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class BridgeRequests : public SimulatedBridge {
 protected:
  /// The response to a request; null if there is none.
  Json response(const std::string& what, const Json& request) {
    published.clear();
    ask("bridge/request/" + what, request.dump());
    const auto all = of("bridge/response/" + what);
    return all.empty() ? Json() : all.front();
  }
  Json data(const std::string& what, const Json& request) {
    const auto answer = response(what, request);
    EXPECT_EQ(answer["status"], "ok") << answer;
    return answer["data"];
  }
  std::string error(const std::string& what, const Json& request) {
    const auto answer = response(what, request);
    EXPECT_EQ(answer["status"], "error") << answer;
    EXPECT_EQ(answer["data"], Json::object());
    return answer["error"].get<std::string>();
  }
};

TEST_F(BridgeRequests, TheTransactionComesBack) {
  make();
  start();
  const auto answer = response("health_check", {{"transaction", "t-1"}});
  EXPECT_EQ(answer, Json::parse(R"({"data":{"healthy":true},"status":"ok","transaction":"t-1"})"));
  EXPECT_TRUE(response("make_coffee", {{"transaction", "t-2"}}).is_null())
      << "what it does not know it does not answer";
}

TEST_F(BridgeRequests, JoiningEndsByItself) {
  make();
  start();
  EXPECT_EQ(data("permit_join", {{"time", 60}}), Json({{"time", 60}}));
  EXPECT_EQ(of("bridge/info").back()["permit_join"], true);
  EXPECT_TRUE(of("bridge/info").back().contains("permit_join_end"));
  time.run_for(61s);
  EXPECT_EQ(of("bridge/info").back()["permit_join"], false);
  world->join(find_model("plug").value());
  published.clear();
  time.run_for(1min);
  EXPECT_THAT(published, IsEmpty()) << "it waits until joining is permitted again";
  EXPECT_THAT(error("permit_join", {{"time", 300}}), HasSubstr("254"));
  EXPECT_EQ(error("permit_join", {{"value", true}}), "Invalid payload");
  EXPECT_EQ(error("permit_join", {{"time", 9}, {"device", "x"}}), "Device 'x' does not exist");
}

TEST_F(BridgeRequests, ARenameMovesTheTopics) {
  make();
  add("plug", "plug");
  start();
  EXPECT_EQ(data("device/rename", {{"from", "plug"}, {"to", "hall/plug"}}),
            Json::parse(R"({"from":"plug","to":"hall/plug","homeassistant_rename":false})"));
  EXPECT_THAT(topics(), ElementsAre("plug", "plug/availability", "hall/plug/availability", "bridge/devices",
                                    "hall/plug", "bridge/response/device/rename"));
  EXPECT_TRUE(published[0].payload.empty() && published[0].retain);
  EXPECT_TRUE(published[1].payload.empty() && published[1].retain);
  EXPECT_EQ(of("bridge/devices")[0][1]["friendly_name"], "hall/plug");
  add("lamp", "lamp");
  EXPECT_EQ(error("device/rename", {{"from", "lamp"}, {"to", "hall/plug"}}),
            "friendly_name 'hall/plug' is already in use");
  for (const auto* bad : {"", "/a", "a/", "a+", "a#", "a/1", "a\nb"})
    EXPECT_THAT(error("device/rename", {{"from", "lamp"}, {"to", bad}}), HasSubstr("riendly")) << bad;
  EXPECT_EQ(error("device/rename", {{"from", "lamp"}}), "Invalid payload");
}

TEST_F(BridgeRequests, ARemovedDeviceIsGoneAndASilentOneNeedsForce) {
  make();
  auto& plug = add("plug", "plug");
  start();
  world->radio().set_faults(plug, {.silent = true});
  EXPECT_THAT(error("device/remove", {{"id", "plug"}}), HasSubstr("Failed to remove device 'plug'"));
  EXPECT_EQ(data("device/remove", {{"id", plug.address()}, {"force", true}})["force"], true);
  EXPECT_THAT(topics(), ElementsAre("plug", "bridge/groups", "bridge/devices", "bridge/response/device/remove"));
  EXPECT_THAT(of("bridge/devices")[0], SizeIs(1));
}

TEST_F(BridgeRequests, OptionsOfADeviceAreInTheInfo) {
  make();
  const auto address = add("plug", "plug").address();
  start();
  const auto changed = data("device/options", {{"id", "plug"}, {"options", {{"optimistic", false}}}});
  EXPECT_EQ(changed["to"], Json({{"optimistic", false}}));
  EXPECT_EQ(changed["restart_required"], false);
  EXPECT_EQ(of("bridge/info")[0]["config"]["devices"][address]["optimistic"], false);
  ask("plug/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_THAT(values("plug", "state"), ElementsAre(R"("ON")", R"("OFF")")) << "heard, then the report; no echo";
}

TEST_F(BridgeRequests, GroupsAreMadeFilledRenamedAndRemoved) {
  make();
  const auto address = add("lamp", "lamp").address();
  start();
  EXPECT_EQ(data("group/add", {{"friendly_name", "lamps"}})["id"], 1);
  EXPECT_EQ(data("group/add", {{"friendly_name", "others"}, {"id", 7}})["id"], 7);
  data("group/members/add", {{"group", "lamps"}, {"device", "lamp"}});
  EXPECT_EQ(of("bridge/groups")[0][0]["members"][0]["ieee_address"], address);
  EXPECT_EQ(data("group/rename", {{"from", 1}, {"to", "all/lamps"}})["from"], "lamps");
  EXPECT_EQ(of("bridge/groups")[0][0]["friendly_name"], "all/lamps");
  data("group/members/remove", {{"group", "all/lamps"}, {"device", "lamp"}});
  EXPECT_THAT(of("bridge/groups")[0][0]["members"], IsEmpty());
  data("group/remove", {{"id", "all/lamps"}});
  EXPECT_EQ(error("group/remove", {{"id", "all/lamps"}}), "Group 'all/lamps' does not exist");
}

TEST_F(BridgeRequests, AMapTakesItsTime) {
  make();
  for (int i = 0; i < 15; ++i) add("plug", "plug " + std::to_string(i));
  start();
  EXPECT_TRUE(response("networkmap", {{"type", "raw"}, {"transaction", 1}}).is_null());
  time.run_for(7s);
  EXPECT_THAT(of("bridge/response/networkmap"), IsEmpty());
  time.run_for(2s);
  const auto map = of("bridge/response/networkmap")[0];
  EXPECT_THAT(map["data"]["value"]["nodes"], SizeIs(16));
  EXPECT_THAT(map["data"]["value"]["links"], SizeIs(15));
  EXPECT_THAT(error("networkmap", {{"type", "graphviz"}}), HasSubstr("raw"));
}

TEST_F(BridgeRequests, ARestartBringsStartUpCopies) {
  make();
  add("plug", "plug");
  start();
  data("restart", Json::object());
  time.run_for(1s);
  EXPECT_EQ(of("bridge/state").back()["state"], "offline");
  time.run_for(10s);
  EXPECT_EQ(of("bridge/state").back()["state"], "online");
  EXPECT_THAT(of("plug"), SizeIs(1));
}

TEST_F(BridgeRequests, AFailedInterviewIsInTheListAndInAnEvent) {
  make();
  const auto address = world->join(find_model("plug").value(), true);
  start();
  data("permit_join", {{"time", 254}});
  time.run_for(30s);
  EXPECT_EQ(of("bridge/event").back()["data"]["status"], "failed");
  const auto record = of("bridge/devices").back()[1];
  EXPECT_EQ(record["interview_state"], "FAILED");
  EXPECT_FALSE(record.contains("definition"));
  published.clear();
  ask(address + "/set", R"({"state":"ON"})");
  time.run_for(20s);
  EXPECT_THAT(published, IsEmpty());
}

TEST_F(BridgeRequests, ManyJoinsPublishFourListsEach) {
  make();
  DefinitionGenerator generator(1);
  start();
  for (std::uint32_t i = 0; i < 20; ++i) world->join(make_model(generator, i));
  data("permit_join", {{"time", 254}});
  time.run_for(30s);
  EXPECT_THAT(of("bridge/devices"), SizeIs(80));
  EXPECT_THAT(of("bridge/devices").back(), SizeIs(21));
}

TEST_F(BridgeRequests, HealthIsPublishedEachTenMinutes) {
  make();
  const auto address = add("plug", "plug").address();
  start();
  time.run_for(21min);
  EXPECT_THAT(of("bridge/health"), SizeIs(2));
  EXPECT_TRUE(of("bridge/health")[0]["devices"].contains(address));
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
