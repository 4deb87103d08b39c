#include <limits>

#include "networks/wsn/wsn_fixture.h"

namespace rubicon::networks::wsn {
namespace {

using model::LineState;
using model::Outcome;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(MoteNetwork, TheSinkGetsItsIslandIdBeforeAnyMoteJoins) {
  start(3);
  EXPECT_EQ(motes->sink(1).island(), kIsland);
  EXPECT_EQ(line(), LineState::kUp);
  EXPECT_EQ(joined(), (std::set<std::string>{"2", "3", "4"}));
  EXPECT_EQ(motes->mote(3).island(), kIsland);
}

TEST_F(MoteNetwork, AMoteJoinsWithWhatItDeclaresAndItsProperties) {
  options["board"] = "EM1000";
  start(1);
  ASSERT_THAT(host.all<model::Join>(), SizeIs(1));
  const auto join = host.all<model::Join>()[0].second;
  EXPECT_EQ(join.device_type, "mote");
  EXPECT_TRUE(join.heard);
  std::set<std::string> names;
  for (const auto& capability : join.capabilities)
    names.insert(fmt::format("{} {}", to_string(capability.point.kind), capability.type_name));
  for (const auto* name : {"sensor light", "sensor temperature", "sensor humidity", "sensor rssi", "actuator led",
                           "property rate", "property mask"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST_F(MoteNetwork, WithoutDemandMotesSendNothing) {
  world(3, em1000());
  open();
  run(10min);
  for (const auto* type : {"light", "temperature", "humidity"}) EXPECT_THAT(readings("2", type), IsEmpty());
  EXPECT_EQ(events("executed"), 0u);
}

TEST_F(MoteNetwork, OnlyTheDemandedSensorOfTheDemandedMoteReports) {
  options["board"] = "EM1000";
  start(3);
  ASSERT_TRUE(demand("3", {"temperature"}));
  run(20s);
  EXPECT_THAT(readings("3", "temperature"), SizeIs(::testing::Ge(15)));
  EXPECT_NEAR(readings("3", "temperature").front(), 25.4, 0.2);
  EXPECT_THAT(readings("3", "light"), IsEmpty());
  EXPECT_THAT(readings("2", "temperature"), IsEmpty());
  EXPECT_THAT(readings("3", "mask"), ElementsAre(0, 2));
}

TEST_F(MoteNetwork, AfterTheLastSubscriberAMoteGoesAsSlowAsItCan) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(10s);
  ASSERT_TRUE(demand("2", {}));
  run(2s);
  const auto before = host.all<model::Updates>().size();
  run(60s);
  EXPECT_LE(host.all<model::Updates>().size(), before + 1);
  EXPECT_EQ(readings("2", "mask").back(), 0);
}

TEST_F(MoteNetwork, ACommandIsSentWhenTheMoteHasItAndTheReleasedFirmwareIgnoresIt) {
  start(1);
  ASSERT_TRUE(light_up("2", 1));
  run(2s);
  EXPECT_EQ(answer(last_request).outcome, Outcome::kSent);
  EXPECT_EQ(events("ignored"), 1u);
}

TEST_F(MoteNetwork, SimulatedMotesObey) {
  auto obedient = em1000();
  obedient.obey = true;
  world(1, obedient);
  open();
  run(5s);
  ASSERT_TRUE(light_up("2", 1));
  run(2s);
  EXPECT_EQ(events("executed"), 1u);
}

TEST_F(MoteNetwork, ACommandToAMissingMoteFailsAndSaysThatTheExecutionIsUnknown) {
  start(1);
  motes->mote(2).kill();
  ASSERT_TRUE(light_up("2", 1));
  run(10s);
  EXPECT_EQ(answer(last_request).outcome, Outcome::kFailed);
  EXPECT_THAT(answer(last_request).text, HasSubstr("whether it was executed is unknown"));
}

TEST_F(MoteNetwork, AMoteThatWasNeverHeardIsNotCommanded) {
  world(1);
  open();
  run(5s);
  EXPECT_EQ(light_up("9", 1).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(light_up("65533", 1).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(light_up("02", 1).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(demand("2", {"co2"}).error().code, ErrorCode::kNotFound);
}

TEST_F(MoteNetwork, ActuatorsTakeTheWholeNumbersOf32BitsAndNoOthers) {
  using Limits = std::numeric_limits<std::int32_t>;
  start(1);
  for (const std::int64_t value : {Limits::min(), 0, Limits::max()}) EXPECT_TRUE(light_up("2", value)) << value;
  for (const std::int64_t value : {Limits::min() - std::int64_t{1}, Limits::max() + std::int64_t{1}})
    EXPECT_EQ(light_up("2", value).error().code, ErrorCode::kOutOfRange) << value;
}

TEST_F(MoteNetwork, AProbeIsAnsweredByASignOfLifeOnly) {
  start(2);
  ASSERT_TRUE(send("2", model::Probe{}));
  run(2s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(1));
  EXPECT_EQ(host.all<model::KeepAlive>()[0].first, "2");
  motes->mote(3).kill();
  ASSERT_TRUE(send("3", model::Probe{}));
  run(10s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(1));
  EXPECT_EQ(answer(last_number).outcome, Outcome::kFailed);
}

TEST_F(MoteNetwork, ARememberedMoteIsRestoredWithItsDeclaration) {
  world(1, em1000());
  options["board"] = "EM1000";
  open();
  run(5s);
  const auto remembered = host.all<model::Join>()[0].second;
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  network.reset();  // the proxy restarts under traffic
  host.delivered.clear();
  open();
  ASSERT_TRUE(send("2", model::Probe{remembered}));
  run(3s);
  EXPECT_THAT(host.all<model::Join>(), IsEmpty()) << "nothing is known better";
  EXPECT_FALSE(host.all<model::KeepAlive>().empty() && host.all<model::Updates>().empty());
  ASSERT_TRUE(light_up("2", 1));
  ASSERT_TRUE(demand("2", {"humidity"})) << "it declared it in another life";
}

TEST_F(MoteNetwork, AMoteThatStillReportsForAnEarlierRunIsThrottled) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  network.reset();
  open();
  run(15s);
  const auto before = host.all<model::Updates>().size();
  run(50s);
  EXPECT_LE(host.all<model::Updates>().size(), before + 1);
}

TEST_F(MoteNetwork, AMoteThatReportsWithoutAKnownJoinIsListedWithWhatItShows) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  network.reset();
  host.delivered.clear();
  open();
  run(5s);
  ASSERT_FALSE(host.all<model::Join>().empty());
  const auto join = host.all<model::Join>()[0].second;
  EXPECT_EQ(join.capabilities.front().type_name, "light");
}

TEST_F(MoteNetwork, AMoteThatIsSwitchedOffAndOnGetsItsCommandAgain) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  motes->mote(2).boot();
  run(5s);
  const auto before = readings("2", "light").size();
  run(10s);
  EXPECT_GE(readings("2", "light").size(), before + 8);
}

TEST_F(MoteNetwork, ASinkThatWasSwitchedOffGetsItsIslandBackWithinTheIslandCheck) {
  start(1);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  motes->sink(1).reboot();
  EXPECT_EQ(motes->sink(1).island(), 11);
  run(35s);
  EXPECT_EQ(motes->sink(1).island(), kIsland);
  const auto before = readings("2", "light").size();
  run(10s);
  EXPECT_GT(readings("2", "light").size(), before);
}

TEST_F(MoteNetwork, AJoinOfAnotherIslandCorrectsTheSinkAndListsNoMote) {
  start(1);
  motes->sink(1).reboot();
  motes->mote(2).boot();
  host.delivered.clear();
  run(3s);
  EXPECT_EQ(motes->sink(1).island(), kIsland);
  EXPECT_THAT(host.all<model::Join>(), IsEmpty());
  EXPECT_GE(counter("foreign-packets"), 1u);
  EXPECT_TRUE(host.words.contains("had that id instead"));
}

TEST_F(MoteNetwork, ALineThatIsPulledOutAndPluggedInAgainHeals) {
  start(2);
  motes->unplug(1, 5s);
  run(4s);
  EXPECT_FALSE(host.failures.empty());
  run(40s);
  EXPECT_EQ(line(), LineState::kUp);
  ASSERT_TRUE(demand("2", {"light"}));
  run(10s);
  EXPECT_FALSE(readings("2", "light").empty());
}

TEST_F(MoteNetwork, DemandSurvivesATerribleRadio) {
  start(3);
  motes->radio().options().loss = 0.3;
  for (const auto* mote : {"2", "3", "4"}) ASSERT_TRUE(demand(mote, {"light"}));
  run(2min);
  for (const auto* mote : {"2", "3", "4"}) EXPECT_THAT(readings(mote, "light"), SizeIs(::testing::Gt(20))) << mote;
}

TEST_F(MoteNetwork, TheTrafficIsRecordedAsTheOriginalDoes) {
  options["record"] = "motes.log";
  start(1);
  ASSERT_TRUE(host.files.has("motes.log"));
  const auto& bytes = host.files.bytes("motes.log");
  // written, 11 bytes: SET_ISLAND_ID 42
  EXPECT_EQ(base::to_hex(ByteView(bytes).subspan(8, 16)), "000000000b00000100000300250a002a");
}

TEST_F(MoteNetwork, ApplicationMessagesGoToMotesUninterpreted) {
  start(1);
  ASSERT_TRUE(send("2", model::Opaque{"mote/3/6/1/reliable", {0x01, 0x01, 0x2c, 0xbe, 0xef}}));
  run(2s);
  EXPECT_EQ(answer(last_number).outcome, Outcome::kSent);
  const auto heard =
      std::find_if(happened.begin(), happened.end(), [](const auto& event) { return event.what == "ignored"; });
  ASSERT_NE(heard, happened.end());
  EXPECT_EQ(base::to_hex(ByteView(heard->record).first(5)), "01012cbeef");
}

TEST_F(MoteNetwork, LearningCommandsAreMadeOfJson) {
  start(1);
  const std::string_view json = R"({"record": "NetIdCmd", "command": 1, "netId": 300, "seq": 48879})";
  const auto sent = send("2", model::Opaque{"mote/json", {json.begin(), json.end()}});
  ASSERT_TRUE(sent) << sent.error().text;
  run(2s);
  const auto heard =
      std::find_if(happened.begin(), happened.end(), [](const auto& event) { return event.what == "ignored"; });
  ASSERT_NE(heard, happened.end());
  EXPECT_EQ(base::to_hex(ByteView(heard->record).first(5)), "01012cbeef");
}

TEST_F(MoteNetwork, WrongApplicationMessagesAreRefusedWithTheReason) {
  start(1);
  EXPECT_EQ(send("2", model::Opaque{"chat", {1}}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(send("2", model::Opaque{"mote/3", {1}}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(send("2", model::Opaque{"mote/3/6/17", {0x12}}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(send("2", model::Opaque{"mote/3/6/17", Bytes(101, 17)}).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(send("x", model::Opaque{"mote/3/6/17", {17}}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(send("", model::Opaque{"mote/am/37", {10, 0, 1}}).error().code, ErrorCode::kRefused);
  EXPECT_EQ(
      send("2", model::SetProperty{9, {Kind::kProperty, types.find("mask")->id, {}}, std::int64_t{3}}).error().code,
      ErrorCode::kRefused);
}

TEST_F(MoteNetwork, NoMessageCommandsAnActuatorPastTheCommandDesk) {
  auto able = em1000();
  able.obey = true;
  world(1, able);
  open();
  run(5s);
  const Bytes relay{0x02, 0, 2, 0, 0, 0, 1};
  const auto carried = motes::encode_net({kIsland, 2, kIsland, motes::kBaseMote, 1, 7, 9,
                                          motes::kTransportConnectionless, motes::kApplicationMockup, relay});
  const auto sent = happened.size();
  for (const auto& answer :
       {send("2", model::Opaque{"mote/3/5/2/reliable", relay}), send("", model::Opaque{"mote/3/5/2", relay}),
        send("2", model::Opaque{"mote/3/5/2", {0x02, 0, 2}}),
        send("2", model::Opaque{"mote/3/5/2/reliable/9", relay}, {IslandId{77}, "wsn-1", "3"}),
        send("", model::Opaque{"mote/am/28", carried})}) {
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, ErrorCode::kRefused);
    EXPECT_THAT(answer.error().text, HasSubstr("set the actuator's .command instead"));
  }
  run(5s);
  EXPECT_EQ(events("executed"), 0u);
  EXPECT_EQ(happened.size(), sent) << "no packet reached a mote";
  EXPECT_TRUE(send("2", model::Opaque{"mote/3/6/2", relay})) << "of another application it may mean anything";
  ASSERT_TRUE(light_up("2", 1));
  run(5s);
  EXPECT_EQ(events("executed"), 1u) << "as the command desk sends it";
}

TEST_F(MoteNetwork, TheAnswerOfAMoteToAnotherIslandIsRoutedThere) {
  start(1);
  // A component of island 77 wants mote 2 to acknowledge: the acknowledgement is for 77 (wsn.md 9.8).
  ASSERT_TRUE(send("2", model::Opaque{"mote/3/6/1/reliable/4660", {0x01, 1, 0x2c, 0, 7}}, {IslandId{77}, "", ""}));
  run(3s);
  const auto routed = std::find_if(host.delivered.begin(), host.delivered.end(), [](const auto& message) {
    return message.destination.island == IslandId{77} && message.kind() == MessageKind::kOpaque;
  });
  ASSERT_NE(routed, host.delivered.end());
  const auto& opaque = std::get<model::Opaque>(routed->body);
  EXPECT_EQ(opaque.type, "mote/9/6/23");
  EXPECT_EQ(base::to_hex(ByteView(opaque.bytes).first(4)), "17123400");
  EXPECT_EQ(routed->source.device, "2");
  EXPECT_EQ(answer(last_number).outcome, Outcome::kSent) << "and its sender learns that it arrived";
}

TEST_F(MoteNetwork, ABroadcastCannotBeAcknowledged) {
  start(2);
  EXPECT_EQ(send("", model::Opaque{"mote/3/6/1/reliable", {1, 1, 0x2c, 0, 7}}).error().code, ErrorCode::kUnsupported);
  ASSERT_TRUE(send("", model::Opaque{"mote/3/6/1", {1, 1, 0x2c, 0, 7}}));
  run(2s);
  EXPECT_EQ(answer(last_number).outcome, Outcome::kSent);
  EXPECT_GE(events("ignored"), 1u);
}

TEST_F(MoteNetwork, ABroadcastIsNoMessageToADevice) {
  start(2);
  const auto answer = send("65535", model::Opaque{"mote/3/6/1", {1, 1, 0x2c, 0, 7}});
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().text, HasSubstr("is addressed to the network"));
  run(2s);
  EXPECT_EQ(events("ignored"), 0u);
}

TEST_F(MoteNetwork, AMoteOfAnotherIslandInReachIsNotOurs) {
  start(1);
  host.delivered.clear();
  from_the_sink("00ffff000072001c002afffd004d000900000166030a23010001012c");
  EXPECT_THAT(host.all<model::Join>(), IsEmpty());
  EXPECT_GE(counter("foreign-motes"), 1u);
}

TEST_F(MoteNetwork, AcknowledgementsForApplicationsAreForwarded) {
  start(1);
  from_the_sink("00ffff000072001c002afffd002a000200000066090617123400");
  const auto found = std::find_if(host.delivered.begin(), host.delivered.end(),
                                  [](const auto& message) { return message.kind() == MessageKind::kOpaque; });
  ASSERT_NE(found, host.delivered.end());
  EXPECT_EQ(std::get<model::Opaque>(found->body).type, "mote/9/6/23");
  EXPECT_EQ(base::to_hex(std::get<model::Opaque>(found->body).bytes), "17123400");
}

TEST_F(MoteNetwork, RecordsOfLearningAreForwardedAsJsonIfConfigured) {
  options["messages-as"] = "json";
  start(1);
  from_the_sink("00ffff000072001c002afffd002a000200000066030619020000403f0000c0bf");
  const auto found = std::find_if(host.delivered.begin(), host.delivered.end(),
                                  [](const auto& message) { return message.kind() == MessageKind::kOpaque; });
  ASSERT_NE(found, host.delivered.end());
  const auto& opaque = std::get<model::Opaque>(found->body);
  EXPECT_EQ(opaque.type, "mote/json");
  const auto json = nlohmann::json::parse(base::as_text(opaque.bytes));
  EXPECT_EQ(json.at("record"), "LearningOutput");
}

TEST_F(MoteNetwork, AMoteRememberedWithoutSensorsStaysUnheardHoweverOftenItIsProbed) {
  start(1);
  host.delivered.clear();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(send("9", model::Probe{model::Join{"mote", "", "", {}}}));
    run(1min);
  }
  for (const auto& [device, join] : host.all<model::Join>()) EXPECT_FALSE(join.heard) << device;
  EXPECT_THAT(host.all<model::KeepAlive>(), IsEmpty());
}

TEST_F(MoteNetwork, AMoteRememberedUnderOtherUnitsIsReadUnderTheseOnes) {
  start(1);
  const auto remembered = host.all<model::Join>()[0].second;
  network.reset();
  host.delivered.clear();
  options["units"] = "raw";
  options["board"] = "EM1000";
  open();
  ASSERT_TRUE(send("2", model::Probe{remembered}));
  ASSERT_THAT(host.all<model::Join>(), SizeIs(1));
  EXPECT_FALSE(host.all<model::Join>()[0].second.heard);
  EXPECT_EQ(host.all<model::Join>()[0].second.model, "TELOSB");
  run(2s);
  ASSERT_TRUE(demand("2", {"lightRaw"}));
  run(5s);
  EXPECT_FALSE(readings("2", "lightRaw").empty());
}

TEST_F(MoteNetwork, AReloadDoesNotBringTheRememberedToLife) {
  start(1);
  model::Join known{"mote", "", "TELOSB", {}};
  model::Capability light;
  light.point = {Kind::kSensor, types.find("light")->id, "1"};
  light.type_name = "light";
  known.capabilities.push_back(light);
  std::ignore = send("9", model::Probe{known});
  host.delivered.clear();
  options["units"] = "raw";
  options["island-check"] = "never";
  auto node = support::config_of(options);
  ConfigErrors errors;
  ConfigReader reader(node, "networks.wsn-1", errors);
  ASSERT_TRUE(network->change({"wsn-1", IslandId{kIsland}, reader, types, {}}));
  std::map<std::string, bool> heard;
  for (const auto& [device, join] : host.all<model::Join>()) heard[device] = join.heard;
  EXPECT_EQ(heard, (std::map<std::string, bool>{{"2", true}, {"9", false}}));
  motes->sink(1).reboot();
  run(5min);
  EXPECT_EQ(motes->sink(1).island(), 11) << "island-check: never";
}

TEST_F(MoteNetwork, ANewerCommandIsNotUndoneByTheRepetitionOfTheOlderOne) {
  auto obedient = em1000();
  obedient.obey = true;
  world(1, obedient);
  open();
  run(5s);
  motes->radio().options().loss = 1;
  ASSERT_TRUE(light_up("2", 1));
  run(500ms);
  motes->radio().options().loss = 0;
  ASSERT_TRUE(light_up("2", 0));
  run(10s);
  std::vector<std::int64_t> values;
  for (const auto& event : happened) {
    if (event.what == "actuator") values.push_back(event.value.value_or(-1));
  }
  EXPECT_THAT(values, ElementsAre(0));
}

TEST_F(MoteNetwork, TheFirstDemandOutlivesAnOutageOfTheRadio) {
  start(1);
  motes->radio().options().loss = 1;
  ASSERT_TRUE(demand("2", {"light"}));
  run(20s);
  motes->radio().options().loss = 0;
  run(40s);
  EXPECT_FALSE(readings("2", "light").empty());
}

TEST_F(MoteNetwork, MessagesOfMotesToTheIslandGoToTheConfiguredComponent) {
  options["messages-to"] = 70001;
  start(1);
  from_the_sink("00ffff000072001c002afffd002a000200000066030619020000403f0000c0bf");
  const auto found = std::find_if(host.delivered.begin(), host.delivered.end(),
                                  [](const auto& message) { return message.kind() == MessageKind::kOpaque; });
  ASSERT_NE(found, host.delivered.end());
  EXPECT_EQ(found->destination.island, OwnerId{70001});
  EXPECT_EQ(found->source.device, "2");
  EXPECT_EQ(std::get<model::Opaque>(found->body).type, "mote/3/6/25");
}

TEST_F(MoteNetwork, AMessageIsHeardOnceUntilItsMoteIsSwitchedOffAndOn) {
  constexpr auto kSaid = "00ffff000072001c002afffd002a000201000766030619020000403f0000c0bf";
  const auto heard = [this] {
    return std::count_if(host.delivered.begin(), host.delivered.end(),
                         [](const auto& message) { return message.kind() == MessageKind::kOpaque; });
  };
  start(1);
  from_the_sink(kSaid);
  from_the_same_sink(kSaid);
  EXPECT_EQ(heard(), 1) << "its sender missed our acknowledgement";
  from_the_same_sink("00ffff000072001c002afffd002a000200000066030a10002a00020100b001");
  from_the_same_sink(kSaid);
  EXPECT_EQ(heard(), 2) << "it counts from the same number again";
}

TEST_F(MoteNetwork, OptionsThatLeaveTheLineAloneChangeWithoutIt) {
  start(1);
  host.delivered.clear();
  options["units"] = "raw";
  auto node = support::config_of(options);
  ConfigErrors errors;
  ConfigReader reader(node, "networks.wsn-1", errors);
  ASSERT_TRUE(network->change({"wsn-1", IslandId{kIsland}, reader, types, {}}));
  ASSERT_THAT(host.all<model::Join>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Join>()[0].second.capabilities.front().type_name, "lightRaw");
  options["source"] = "sf@127.0.0.1:9002";
  node = support::config_of(options);
  ConfigReader other(node, "networks.wsn-1", errors);
  EXPECT_EQ(network->change({"wsn-1", IslandId{kIsland}, other, types, {}}).error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(host.failures.empty());
}

}  // namespace
}  // namespace rubicon::networks::wsn
