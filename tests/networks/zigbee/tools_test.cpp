#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class ZigbeeTools : public House {
 protected:
  ZigbeeTools() { start(); }
  json reply() const {
    const auto all = to_tools("zigbee.reply");
    return all.empty() ? json() : all.back();
  }
};

TEST_F(ZigbeeTools, PermitAsksTheBridgeAndShowsTheJoinsUntilItCloses) {
  ask({{"id", "a"}, {"do", "permit"}, {"seconds", 60}, {"via", "plug"}});
  EXPECT_EQ(requested("permit_join")["time"], 60);
  EXPECT_EQ(requested("permit_join")["device"], "0x00124b0010000002");
  EXPECT_THAT(to_tools("zigbee.reply"), IsEmpty()) << "not before the bridge answered";
  respond("permit_join", {{"time", 60}});
  EXPECT_EQ(reply()["ok"], true);
  EXPECT_EQ(reply()["id"], "a");
  EXPECT_NEAR(reply()["until"].get<double>(), base::to_seconds(host.time.wall_now()) + 60, 1);
  say("bridge/event",
      {{"type", "device_joined"}, {"data", {{"ieee_address", "0x00124b0010000009"}, {"friendly_name", "new"}}}});
  say("bridge/event",
      {{"type", "device_interview"},
       {"data", {{"ieee_address", "0x00124b0010000009"}, {"friendly_name", "new"}, {"status", "failed"}}}});
  auto events = to_tools("zigbee.event");
  ASSERT_THAT(events, SizeIs(2));
  EXPECT_EQ(events[0]["event"], "joined");
  EXPECT_EQ(events[0]["address"], "00124b0010000009");
  EXPECT_EQ(events[0]["id"], "a");
  EXPECT_EQ(events[1]["event"], "failed");
  EXPECT_NE(events[1].value("why", ""), "");
  host.time.run_for(60s);
  ASSERT_THAT(to_tools("zigbee.event"), SizeIs(3));
  EXPECT_EQ(to_tools("zigbee.event").back()["event"], "closed");
  say("bridge/event",
      {{"type", "device_announce"}, {"data", {{"ieee_address", "0x00124b0010000009"}, {"friendly_name", "new"}}}});
  EXPECT_THAT(to_tools("zigbee.event"), SizeIs(3));
}

TEST_F(ZigbeeTools, PermitClosesWhenAnotherClientClosesIt) {
  ask({{"id", "a"}, {"do", "permit"}, {"seconds", 254}});
  say("bridge/info", info("2.14.1", true), true);  // as recorded: before the response
  respond("permit_join", {{"time", 254}});
  EXPECT_THAT(to_tools("zigbee.event"), IsEmpty());
  say("bridge/info", info("2.14.1", false), true);
  ASSERT_THAT(to_tools("zigbee.event"), SizeIs(1));
  EXPECT_EQ(to_tools("zigbee.event")[0]["event"], "closed");
}

TEST_F(ZigbeeTools, ThePermitOfOneToolTooManyIsRefusedBeforeItOpensTheNetwork) {
  for (int i = 0; i < 16; ++i) {
    ask({{"id", std::to_string(i)}, {"do", "permit"}, {"seconds", 254}});
    respond("permit_join", {{"time", 254}});
    ASSERT_EQ(reply()["ok"], true);
  }
  const auto all = [this] { return broker.published("zigbee2mqtt/bridge/request/permit_join").size(); };
  ask({{"id", "16"}, {"do", "permit"}, {"seconds", 254}});
  EXPECT_EQ(reply()["id"], "16");
  EXPECT_EQ(reply()["ok"], false);
  EXPECT_EQ(all(), 16U);
  ask({{"id", "3"}, {"do", "permit"}, {"seconds", 100}});
  EXPECT_EQ(all(), 17U) << "it watches already";
}

TEST_F(ZigbeeTools, WhatChangesTheInstallationNeedsAnAdministratorsMessage) {
  const std::vector<json> changes{{{"do", "permit"}, {"seconds", 60}},
                                  {{"do", "rename"}, {"device", "plug"}, {"to", "other"}},
                                  {{"do", "remove"}, {"device", "plug"}},
                                  {{"do", "options"}, {"device", "plug"}, {"set", {{"retain", true}}}}};
  for (const auto& request : changes) {
    EXPECT_EQ(tag_of(request), "zigbee.admin") << request;
    ask(request, "zigbee.request");
    EXPECT_EQ(reply()["ok"], false) << request;
    EXPECT_EQ(reply()["why"], "this request needs a message of the type zigbee.admin") << request;
  }
  for (const auto* what : {"permit_join", "device/rename", "device/remove", "device/options"})
    EXPECT_EQ(requested(what), json()) << what;
  ask({{"do", "options"}, {"device", "plug"}}, "zigbee.request");
  EXPECT_EQ(reply()["ok"], true) << "reading them changes nothing";
  ask({{"do", "devices"}}, "zigbee.admin");
  EXPECT_EQ(reply()["ok"], true) << "all requests may be sent so";
}

TEST_F(ZigbeeTools, LastSeenIsThatOfTheStateMessages) {
  availability = true;
  const auto device = [this] {
    ask({{"id", "d"}, {"do", "devices"}});
    return reply()["devices"][1];
  };
  say("air/availability", {{"state", "online"}}, true);
  EXPECT_FALSE(device().contains("last_seen")) << "a stored availability proves no time";
  EXPECT_EQ(device()["availability"], "online");
  report("air", {{"temperature", 21.5}});
  const auto seen = device()["last_seen"].get<double>();
  EXPECT_NEAR(seen, base::to_seconds(host.time.wall_now()), 1);
  host.time.run_for(1min);
  say("air/availability", "", true);
  EXPECT_EQ(device()["last_seen"].get<double>(), seen);
  EXPECT_FALSE(device().contains("availability")) << "it was cleared";
}

TEST_F(ZigbeeTools, PermitForNoTimeClosesForAll) {
  ask({{"id", "a"}, {"do", "permit"}, {"seconds", 254}});
  respond("permit_join", {{"time", 254}});
  ask({{"id", "b"}, {"do", "permit"}, {"seconds", 0}});
  respond("permit_join", {{"time", 0}});
  EXPECT_EQ(reply()["id"], "b");
  ASSERT_THAT(to_tools("zigbee.event"), SizeIs(1));
  EXPECT_EQ(to_tools("zigbee.event")[0]["id"], "a");
}

TEST_F(ZigbeeTools, DevicesAreListedWithTheirConditionInParts) {
  report("plug", {{"state", "ON"}, {"linkquality", 120}});
  auto failed = button();
  failed["interview_state"] = "FAILED";
  list({plug(), thermometer(), failed});
  host.time.run_for(100ms);
  ask({{"id", "d"}, {"do", "devices"}});
  const auto devices = reply()["devices"];
  ASSERT_EQ(devices.size(), 3U);
  EXPECT_EQ(reply()["more"], false);
  EXPECT_EQ(devices[0]["address"], kPlug);
  EXPECT_EQ(devices[0]["name"], "plug");
  EXPECT_EQ(devices[0]["role"], "router");
  EXPECT_EQ(devices[0]["vendor"], "Maker");
  EXPECT_EQ(devices[0]["interview"], "successful");
  EXPECT_EQ(devices[0]["link_quality"], 120);
  EXPECT_GT(devices[0]["points"], 2);
  EXPECT_GT(devices[0]["last_seen"], 0);
  ask({{"id", "d"}, {"do", "devices"}, {"from", 2}});
  ASSERT_EQ(reply()["devices"].size(), 1U);
  EXPECT_EQ(reply()["devices"][0]["address"], kButton);
}

TEST_F(ZigbeeTools, AListThatIsTooLongForOneMessageIsReadInParts) {
  auto all = json::array();
  for (int i = 0; i < 2000; ++i) {
    auto one = thermometer("air " + std::to_string(i));
    one["ieee_address"] = fmt::format("0x00124b002{:07x}", i);
    all.push_back(std::move(one));
  }
  list(all);
  host.time.run_for(20s);
  std::size_t seen = 0;
  for (int part = 0; part < 100; ++part) {
    ask({{"id", "d"}, {"do", "devices"}, {"from", seen}});
    EXPECT_LT(reply().dump().size(), 200'000U);
    seen += reply()["devices"].size();
    if (reply()["more"] == false) break;
  }
  EXPECT_EQ(seen, 2000U);
}

TEST_F(ZigbeeTools, RenameNamesTheDeviceByItsAddress) {
  ask({{"id", "r"}, {"do", "rename"}, {"device", "air"}, {"to", "cellar/air"}});
  EXPECT_EQ(requested("device/rename")["from"], "0x00124b0010000003");
  EXPECT_EQ(requested("device/rename")["to"], "cellar/air");
  respond("device/rename", {{"from", "air"}, {"to", "cellar/air"}});
  EXPECT_EQ(reply()["ok"], true);
  ask({{"id", "s"}, {"do", "rename"}, {"device", "0x00124b0010000002"}, {"to", "x"}});
  refuse("device/rename", "friendly_name 'x' is already in use");
  EXPECT_EQ(reply()["ok"], false);
  EXPECT_THAT(reply().value("why", ""), HasSubstr("already in use"));
  ask({{"id", "t"}, {"do", "rename"}, {"device", "absent"}, {"to", "x"}});
  EXPECT_THAT(reply().value("why", ""), HasSubstr("absent"));
}

TEST_F(ZigbeeTools, AWordOfTheIslandComesWithTheAddress) {
  ask({{"id", "r"}, {"do", "remove"}, {"device", "bath"}, {"address", kThermometer}});
  EXPECT_EQ(requested("device/remove")["id"], "0x00124b0010000003");
  ask({{"id", "o"}, {"do", "options"}, {"device", "air"}, {"address", kThermometer}, {"set", {{"retain", true}}}});
  EXPECT_EQ(requested("device/options")["id"], "0x00124b0010000003") << "both words mean it";
  ask({{"id", "p"}, {"do", "permit"}, {"via", "router"}, {"address", kPlug}});
  EXPECT_EQ(requested("permit_join")["device"], "0x00124b0010000002");
}

TEST_F(ZigbeeTools, AWordThatMeansAnotherDeviceOnTheIslandIsRefused) {
  ask({{"id", "r"}, {"do", "remove"}, {"device", "air"}, {"address", kPlug}});
  EXPECT_EQ(reply()["ok"], false);
  EXPECT_THAT(reply().value("why", ""), AllOf(HasSubstr("'air'"), HasSubstr(kThermometer), HasSubstr(kPlug)));
  EXPECT_TRUE(requested("device/remove").is_null());
}

TEST_F(ZigbeeTools, RemoveAndForce) {
  ask({{"id", "r"}, {"do", "remove"}, {"device", "air"}, {"force", true}});
  EXPECT_EQ(requested("device/remove")["id"], "0x00124b0010000003");
  EXPECT_EQ(requested("device/remove")["force"], true);
  respond("device/remove", {{"id", "air"}});
  EXPECT_EQ(reply()["ok"], true);
}

/// By this network or by any other client: the answer of the bridge is the same.
TEST_F(ZigbeeTools, ADeviceThatTheBridgeRemovedLeavesAtOnce) {
  list({plug(), thermometer()});
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  say("bridge/response/device/remove", {{"data", {{"id", "0x00124b0010000004"}}}, {"status", "error"}, {"error", "x"}});
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  say("bridge/response/device/remove", {{"data", {{"id", "0x00124b0010000004"}}}, {"status", "ok"}});
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(1));
  say("bridge/response/device/remove", {{"data", {{"id", "air"}}}, {"status", "ok"}});
  list(json::array({plug()}));
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(2));
  EXPECT_EQ(host.all<model::Leave>()[1].first, kThermometer);
}

TEST_F(ZigbeeTools, OptionsAreReadFromTheListAndTheConfiguration) {
  auto rich = plug();
  rich["definition"]["options"] = {{{"type", "numeric"},
                                    {"name", "transition"},
                                    {"property", "transition"},
                                    {"access", 2},
                                    {"unit", "s"},
                                    {"value_min", 0},
                                    {"description", "Transition time"}},
                                   {{"type", "binary"},
                                    {"name", "state_action"},
                                    {"property", "state_action"},
                                    {"access", 2},
                                    {"value_on", true},
                                    {"value_off", false}}};
  list({rich, thermometer(), button()});
  auto described = info();
  described["config"]["devices"]["0x00124b0010000002"] = {
      {"friendly_name", "plug"}, {"transition", 2}, {"retain", true}};
  say("bridge/info", described, true);
  ask({{"id", "o"}, {"do", "options"}, {"device", "plug"}});
  const auto options = reply()["options"];
  ASSERT_EQ(options.size(), 3U) << reply();
  EXPECT_EQ(options[0]["name"], "transition");
  EXPECT_EQ(options[0]["value"], 2);
  EXPECT_EQ(options[0]["unit"], "s");
  EXPECT_EQ(options[1]["values"], json({true, false}));
  EXPECT_EQ(options[2]["name"], "retain");
}

TEST_F(ZigbeeTools, Pitfall18_SettingAnOptionReportsIfTheBridgeMustBeRestarted) {
  ask({{"id", "o"}, {"do", "options"}, {"device", "plug"}, {"set", {{"transition", 3}}}});
  EXPECT_EQ(requested("device/options")["options"], json({{"transition", 3}}));
  respond("device/options", {{"from", json::object()}, {"to", {{"transition", 3}}}, {"restart_required", true}});
  EXPECT_EQ(reply()["restart_required"], true);
  EXPECT_EQ(reply()["options"][0]["value"], 3);
}

TEST_F(ZigbeeTools, AMapIsMadeOnceAndReadInParts) {
  ask({{"id", "m"}, {"do", "map"}});
  host.time.run_for(60s);
  EXPECT_THAT(to_tools("zigbee.reply"), IsEmpty()) << "a map takes its time";
  auto nodes = json::array(), links = json::array();
  for (int i = 0; i < 100; ++i)
    nodes.push_back(json{{"ieeeAddr", fmt::format("0x00124b002{:07x}", i)}, {"friendlyName", "n"}, {"type", "Router"}});
  for (int i = 0; i < 2000; ++i)
    links.push_back(json{{"source", {{"ieeeAddr", fmt::format("0x00124b002{:07x}", i % 100)}}},
                         {"target", {{"ieeeAddr", fmt::format("0x00124b002{:07x}", (i + 1) % 100)}}},
                         {"linkquality", i % 255},
                         {"depth", 1},
                         {"relationship", 2}});
  respond("networkmap", {{"type", "raw"}, {"routes", false}, {"value", {{"nodes", nodes}, {"links", links}}}});
  std::size_t read_nodes = reply()["nodes"].size(), read_links = reply()["links"].size();
  while (reply().value("more", false))
    ask({{"id", "m"}, {"do", "map"}, {"from", reply()["next"]}}), read_nodes += reply()["nodes"].size(),
        read_links += reply()["links"].size();
  EXPECT_EQ(read_nodes, 100U);
  EXPECT_EQ(read_links, 2000U);
  EXPECT_THAT(broker.published("zigbee2mqtt/bridge/request/networkmap"), SizeIs(1));
}

TEST_F(ZigbeeTools, MonitorShowsWhatPassesInBothDirections) {
  ask({{"id", "w"}, {"do", "monitor"}, {"seconds", 60}});
  EXPECT_EQ(reply()["ok"], true);
  EXPECT_EQ(reply()["line"], true);
  say("air", {{"temperature", 21.5}});
  say("bridge/info", {{"version", "2.14.1"}, {"config", {{"secret", "x"}}}}, true);
  ask({{"id", "x"}, {"do", "rename"}, {"device", "air"}, {"to", "kitchen/air"}}, "zigbee.admin");
  const auto seen = to_tools("zigbee.message");
  ASSERT_THAT(seen, SizeIs(3));
  EXPECT_EQ(seen[0]["direction"], "in");
  EXPECT_EQ(seen[0]["topic"], "air");
  EXPECT_EQ(seen[0]["text"], R"({"temperature":21.5})");
  EXPECT_EQ(seen[1]["topic"], "bridge/info");
  EXPECT_FALSE(seen[1].contains("text")) << "settings may have secrets";
  EXPECT_GT(seen[1]["bytes"], 20);
  EXPECT_EQ(seen[2]["direction"], "out");
  EXPECT_EQ(seen[2]["topic"], "bridge/request/device/rename");
  host.time.run_for(61s);
  say("air", {{"temperature", 22}});
  EXPECT_THAT(to_tools("zigbee.message"), SizeIs(3)) << "nobody watches any longer";
}

TEST_F(ZigbeeTools, HealthHasTheBridgeAndItsLastReport) {
  say("bridge/health",
      {{"response_time", 1},
       {"os", {{"load_average", {0.5, 0.4, 0.3}}, {"memory_percent", 40}}},
       {"process", {{"uptime_sec", 100}}}},
      true);
  ask({{"id", "h"}, {"do", "health"}});
  respond("health_check", {{"healthy", true}});
  EXPECT_EQ(reply()["healthy"], true);
  EXPECT_EQ(reply()["bridge"]["version"], "2.14.1");
  EXPECT_TRUE(reply().contains("health"));
}

/// The bridge does not answer requests that it does not know.
TEST_F(ZigbeeTools, AnAnswerThatDoesNotComeIsAnAnswerToo) {
  ask({{"id", "x"}, {"do", "remove"}, {"device", "air"}});
  host.time.run_for(11s);
  ASSERT_THAT(to_tools("zigbee.reply"), SizeIs(1));
  EXPECT_EQ(reply()["ok"], false);
  EXPECT_THAT(reply().value("why", ""), HasSubstr("10 s"));
  respond("device/remove", {{"id", "air"}});
  EXPECT_THAT(to_tools("zigbee.reply"), SizeIs(1)) << "too late";
}

TEST_F(ZigbeeTools, AnswersToOtherClientsAreNotOurs) {
  ask({{"id", "x"}, {"do", "remove"}, {"device", "air"}});
  say("bridge/response/device/remove", {{"data", {{"id", "plug"}}}, {"status", "ok"}, {"transaction", "theirs"}});
  say("bridge/response/device/remove", {{"data", {{"id", "plug"}}}, {"status", "ok"}});
  EXPECT_THAT(to_tools("zigbee.reply"), IsEmpty());
  respond("device/remove", {{"id", "air"}});
  EXPECT_THAT(to_tools("zigbee.reply"), SizeIs(1));
}

TEST_F(ZigbeeTools, RequestsThatWaitAreRefusedWhenTheBridgeGoes) {
  ask({{"id", "x"}, {"do", "remove"}, {"device", "air"}});
  ask({{"id", "p"}, {"do", "permit"}, {"seconds", 60}});
  respond("permit_join", {{"time", 60}});
  online(false);
  const auto replies = to_tools("zigbee.reply");
  ASSERT_THAT(replies, SizeIs(2));
  EXPECT_EQ(replies[1]["ok"], false);
  EXPECT_THAT(replies[1].value("why", ""), HasSubstr("offline"));
  EXPECT_EQ(to_tools("zigbee.event").back()["event"], "closed");
  ask({{"id", "y"}, {"do", "health"}});
  EXPECT_EQ(reply()["id"], "y");
  EXPECT_EQ(reply()["ok"], false);
  ask({{"id", "z"}, {"do", "devices"}});
  EXPECT_EQ(reply()["devices"].size(), 3U) << "what is known can be read";
}

TEST_F(ZigbeeTools, TooManyRequestsAreRefused) {
  for (int i = 0; i < 70; ++i) ask({{"id", std::to_string(i)}, {"do", "health"}});
  EXPECT_THAT(to_tools("zigbee.reply"), SizeIs(6));
  EXPECT_EQ(reply()["ok"], false);
  host.time.run_for(11s);
  EXPECT_THAT(to_tools("zigbee.reply"), SizeIs(70));
}

TEST_F(ZigbeeTools, WhatIsNoRequestIsRefusedAtOnce) {
  ask({{"id", "q"}, {"do", "explode"}});
  EXPECT_EQ(reply()["ok"], false);
  ask({{"id", "q"}, {"do", "permit"}, {"seconds", 255}});
  EXPECT_EQ(reply()["ok"], false);
  ask({{"id", "q"}, {"do", "permit"}, {"seconds", "ten"}});
  EXPECT_EQ(reply()["ok"], false);
  ask({{"id", "q"}, {"do", "options"}, {"device", "plug"}, {"set", 5}});
  EXPECT_EQ(reply()["ok"], false);
  for (const auto* text : {"", "[]", "{", "\xff"}) {
    const std::string bytes = text;
    EXPECT_FALSE(send({}, model::Opaque{"zigbee.request", Bytes(bytes.begin(), bytes.end())}));
  }
  EXPECT_FALSE(send({}, model::Opaque{"knx.request", Bytes{'{', '}'}}));
}

TEST_F(ZigbeeTools, ARequestToOneDeviceIsRefused) {
  const std::string bytes = R"({"id": "q", "do": "remove", "device": "air"})";
  for (const auto* tag : {"zigbee.admin", "zigbee.request"}) {
    const auto answer = send(kPlug, model::Opaque{tag, Bytes(bytes.begin(), bytes.end())});
    ASSERT_FALSE(answer) << tag;
    EXPECT_EQ(answer.error().code, ErrorCode::kRefused);
    EXPECT_THAT(answer.error().text, HasSubstr("concerns the whole network"));
  }
  host.time.run_for(10ms);
  EXPECT_EQ(requested("device/remove"), json());
  EXPECT_THAT(to_tools("zigbee.reply"), IsEmpty());
}

TEST_F(ZigbeeTools, TheStateHasTheBridgeAndTheSettingsToChange) {
  host.time.run_for(1s);
  const auto texts = state().texts;
  const auto bridge = json::parse(texts.at("bridge"));
  EXPECT_EQ(bridge["version"], "2.14.1");
  EXPECT_EQ(bridge["channel"], 11);
  EXPECT_EQ(bridge["permit_join"], false);
  const auto settings = json::parse(texts.at("settings"));
  ASSERT_FALSE(settings.empty()) << "availability is off";
  EXPECT_NE(settings[0]["why"], "");
  const auto broker_text = json::parse(texts.at("broker"));
  EXPECT_EQ(broker_text["tls"], false);
  EXPECT_EQ(broker_text["user"], false);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
