#include <fmt/format.h>
#include <gmock/gmock.h>

#include "networks/log/log_recordings.h"
#include "networks/log/recorded_device.h"

namespace rubicon::networks::log {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(LogRecording, IsRecognisedByItsFirstBytesAndPlaysJoinsAndReadings) {
  Writer writer;
  join_mote(writer);
  writer.user = writer.now - 3s;
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "686.6");
  writer.user = {};
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "686.6");
  play(writer.file());
  ASSERT_EQ(joins().size(), 1u);
  const auto join = joins()[0];
  EXPECT_EQ(join.id, "7");
  EXPECT_EQ(join.name, "Mote ä");
  EXPECT_EQ(join.model, "EM1000");
  EXPECT_EQ(join.device_type, "mote");
  EXPECT_EQ(listener_.of<model::Join>()[0].second.source.device, "0x07");
  EXPECT_EQ(join.capabilities.at(0).deadline, Duration(1min));
  EXPECT_THAT(delivered(), ElementsAre("686.6", "686.6"));
  EXPECT_EQ(listener_.readings()[0].user_time, WallTime(1'699'999'997s));
  EXPECT_EQ(listener_.readings()[1].user_time, WallTime{});
  const auto updates = listener_.of<model::Updates>();
  EXPECT_EQ(updates[1].first - updates[0].first, 1s);
}

TEST_F(LogRecording, CommandsStatusesAndOtherTuplesSayNothing) {
  Writer writer;
  join_mote(writer);
  for (const auto* key : {"proxy.wsn-1.7.actuator.switch-1.command", "proxy.wsn-1.7.sensor.light-1.status",
                          "proxy.wsn-1.7.status", "proxy.wsn-1.status", "proxy.wsn-1.devices", "proxy.networks",
                          "proxy.wsn-1.property.line.value", "robot.position", "proxy.wsn-1", "proxy"}) {
    writer.set(key, "1");
  }
  writer.owner = OwnerId(70000);
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "5");
  play(writer.file());
  EXPECT_EQ(joins().size(), 1u);
  EXPECT_THAT(delivered(), IsEmpty());
  EXPECT_THAT(listener_.of<model::Leave>(), IsEmpty());
}

TEST_F(LogRecording, DeletedDevicesLeaveAndLostSensorsGoWithTheNextJoin) {
  Writer writer;
  join_mote(writer);
  writer.same_turn = true;
  writer.describe("proxy.wsn-1.7.sensor.temperature-1.description",
                  R"({"type":"temperature","type_id":2,"access":"read"})");
  auto both = kMote;
  both.replace(both.find("\"light-1\""), 9, "\"light-1\",\"temperature-1\"");
  writer.describe("proxy.wsn-1.7.description", both);
  writer.same_turn = false;
  writer.now += 1s;
  writer.same_turn = true;
  writer.erase("proxy.wsn-1.7.sensor.temperature-1.value");
  writer.erase("proxy.wsn-1.7.sensor.temperature-1.description");
  writer.describe("proxy.wsn-1.7.description", kMote);
  writer.now += 1s;
  writer.erase("proxy.wsn-1.7.description");
  play(writer.file());
  std::vector<std::size_t> sizes;
  for (const auto& join : joins()) sizes.push_back(join.capabilities.size());
  EXPECT_THAT(sizes, ElementsAre(1u, 2u, 1u));
  const auto leaves = listener_.of<model::Leave>();
  ASSERT_EQ(leaves.size(), 1u);
  EXPECT_EQ(leaves[0].second.source.device, "0x07");
}

TEST_F(LogRecording, SnapshotsTellNothingTwice) {
  Writer first, second;
  join_mote(first);
  first.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  second.now = first.now;
  second.mark("snapshot");
  // The same write: sequence and time are those of the first file.
  recording::BlockBuilder block;
  block.add({RecordKind::kPresent,
             first.now + 1s,
             first.owner,
             "proxy.wsn-1.7.sensor.light-1.value",
             "1",
             "text/plain",
             first.owner,
             5,
             first.now,
             {},
             {}});
  second.add(RecordKind::kPresent, "proxy.wsn-1.7.sensor.light-1.description", kLight, "application/json");
  second.add(RecordKind::kPresent, "proxy.wsn-1.7.description", kMote, "application/json");
  second.close();
  const auto extra = block.close();
  auto file = second.file() + std::string(base::as_text(extra));
  Writer end;
  end.now = second.now;
  end.mark("complete");
  file += end.file();
  listener_.files.files["second.rec"] = file;
  listener_.files.files["home.rec"] = first.file();
  made_ = make_log(listener_, map({{"files", list({"home.rec", "second.rec"})}}), types_);
  ASSERT_NE(made_.network, nullptr);
  ASSERT_TRUE(made_.network->open());
  listener_.time.run_for(1min);
  EXPECT_EQ(joins().size(), 1u);
  EXPECT_THAT(delivered(), ElementsAre("1"));
  EXPECT_THAT(listener_.of<model::Leave>(), IsEmpty());
}

/// Blocks of any number of records: a few are read ahead, but never beyond the end of a block, whose memory the next
/// one takes.
TEST_F(LogRecording, PlaysEachRecordOnceAndInOrderHoweverManyABlockHas) {
  Writer writer;
  join_mote(writer);
  writer.close();
  std::vector<std::string> expected;
  for (int records = 1; records <= 40; ++records) {
    for (int i = 0; i < records; ++i) {
      expected.push_back(std::to_string(1000 * records + i));
      writer.set("proxy.wsn-1.7.sensor.light-1.value", expected.back());
    }
    writer.close();
  }
  play(writer.file(), {{"speed", scalar("max")}});
  EXPECT_EQ(delivered(), expected);
}

TEST_F(LogRecording, WhatACompleteSnapshotDoesNotNameLeaves) {
  Writer writer;
  join_mote(writer);
  writer.mark("start");
  writer.mark("complete");
  play(writer.file());
  EXPECT_EQ(listener_.of<model::Leave>().size(), 1u);
}

TEST_F(LogRecording, ADamagedSnapshotMakesNobodyLeave) {
  Writer writer;
  join_mote(writer);
  writer.mark("snapshot");
  writer.close();
  auto file = writer.file() + "damage";
  Writer end;
  end.mark("complete");
  const auto head = recording::encode_head({OwnerId(6541), "proxy", {}, "test"});
  play(file + end.file().substr(0));
  EXPECT_EQ(listener_.counter("damaged"), 1u);
  EXPECT_THAT(listener_.of<model::Leave>(), IsEmpty());
}

TEST_F(LogRecording, AnotherNetworkIsPlayedByItsName) {
  Writer writer;
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "20");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "21");
  play(writer.file(), {{"network", scalar("knx")}});
  EXPECT_EQ(joins().at(0).id, "1_1_1");
  EXPECT_EQ(joins().at(0).capabilities.at(0).initial, Value(std::int64_t{20}));
  EXPECT_THAT(delivered(), ElementsAre("21"));
}

TEST_F(LogRecording, TuplesOfTheIslandItselfAreNoNetwork) {
  Writer writer;
  writer.set("proxy.settings.status", "{\"state\":\"idle\"}");
  writer.set("proxy.recorder.all.status", "{\"state\":\"recording\"}");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "20");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "21");
  play(writer.file());
  EXPECT_THAT(listener_.lines, IsEmpty());
  EXPECT_THAT(delivered(), ElementsAre("21"));
}

TEST_F(LogRecording, SeveralNetworksEndTheLineOnceWithTheirNamesAndTellNothing) {
  Writer writer;
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "20");
  play(writer.file());
  const std::string why =
      "home.rec: the recording holds the networks knx, wsn-1; choose one with the option `network`, for example "
      "`network: knx`";
  EXPECT_THAT(listener_.failures, IsEmpty()) << "it would be opened again and again";
  EXPECT_THAT(lines(), ElementsAre("connecting", "ended: " + why));
  EXPECT_THAT(listener_.lines, ElementsAre(why));
  EXPECT_THAT(delivered(), IsEmpty());
}

TEST_F(LogRecording, AllNetworksOfTheFileAreNamedAlsoThoseOfItsLastBlock) {
  Writer writer;
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  writer.set("proxy.knx.1_1_1.sensor.temperature-1.value", "20");
  for (int i = 0; i < 5; ++i) {
    writer.close();
    for (int k = 0; k < 1000; ++k) writer.set("proxy.wsn-1.7.sensor.light-1.value", std::to_string(k));
  }
  writer.set("proxy.salad.status", "{}");
  writer.close();
  writer.set("proxy.zigbee-1.3.actuator.lamp-1.value", "on");
  play(writer.file());
  const std::string why =
      "home.rec: the recording holds the networks knx, salad, wsn-1, zigbee-1; choose one with the option `network`, "
      "for example "
      "`network: knx`";
  EXPECT_THAT(lines(), ElementsAre("connecting", "ended: " + why));
  EXPECT_THAT(listener_.lines, ElementsAre(why));
  EXPECT_THAT(delivered(), IsEmpty());
}

TEST_F(LogRecording, OpenedAgainAfterItEndedItReadsTheRecordingAnew) {
  Writer both, one;
  both.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  both.set("proxy.knx.1_1_1.sensor.temperature-1.value", "20");
  one.user = one.now;
  one.set("proxy.wsn-1.7.sensor.light-1.value", "1");
  play(both.file());
  listener_.files.files["home.rec"] = one.file();
  ASSERT_TRUE(made_.network->open());
  listener_.time.run_for(1min);
  EXPECT_THAT(delivered(), ElementsAre("1"));
}

TEST_F(LogRecording, TheLineIsUpWhenTheHeadAndTheNetworksAreRead) {
  Writer writer;
  join_mote(writer);
  const auto file = writer.file();
  play(file);
  EXPECT_THAT(lines(), ElementsAre("connecting", "up", "ended: the recording ended"));
  listener_.heard.clear();
  play(file.substr(0, file.size() - 1));
  EXPECT_THAT(lines(), ElementsAre("connecting", "ended: the recording ended")) << "no block was whole";
  listener_.heard.clear();
  listener_.failures.clear();
  listener_.files.files["home.rec"] = file;
  made_ = make_log(listener_, map({{"file", scalar("home.rec")}}), types_);
  ASSERT_TRUE(made_.network->open());
  listener_.files.broken = true;
  listener_.time.run_for(1min);
  EXPECT_THAT(lines(), ElementsAre("connecting"));
  EXPECT_EQ(listener_.failures.size(), 1u) << "a disk may come back";
}

TEST_F(LogRecording, AnotherPrefixIsThatOfTheRecording) {
  Writer writer;
  writer.prefix = "house";
  writer.user = writer.now;
  writer.set("house.wsn-1.7.sensor.light-1.value", "1");
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "2");
  play(writer.file());
  EXPECT_THAT(delivered(), ElementsAre("1"));
}

TEST_F(LogRecording, SaidToBePacketsItEndsTheLine) {
  Writer writer;
  join_mote(writer);
  play(writer.file(), {{"format", scalar("packets")}});
  EXPECT_THAT(lines(), ElementsAre(HasSubstr("ended: home.rec: is a recording, expected packets")));
  EXPECT_THAT(listener_.failures, IsEmpty());
}

TEST_F(LogRecording, AFileTooShortToTellItsFormatIsTriedAgainUnlessTheFormatIsSaid) {
  for (const std::string text : {"", "x", "\x89RUBREC"}) {
    play(text);
    ASSERT_FALSE(opened_);
    EXPECT_THAT(opened_.error().text,
                HasSubstr(fmt::format("home.rec: has {} bytes, expected at least 8", text.size())));
    play(text, {{"format", scalar("packets")}});
    EXPECT_TRUE(opened_);
  }
}

TEST_F(LogRecording, CutAtAnyByteOrBitsFlippedItPlaysWhatIsSound) {
  Writer writer;
  join_mote(writer);
  writer.close();
  for (int i = 0; i < 3; ++i) writer.set("proxy.wsn-1.7.sensor.light-1.value", std::to_string(i));
  const auto whole = writer.file();
  for (std::size_t size = 0; size < whole.size(); size += 3) {
    listener_.heard.clear();
    play(whole.substr(0, size), {{"format", scalar("recording")}, {"speed", scalar("max")}}, 1s);
    EXPECT_LE(delivered().size(), 3u);
  }
  for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 5) {
    auto damaged = whole;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    listener_.heard.clear();
    play(damaged, {{"format", scalar("recording")}, {"speed", scalar("max")}}, 1s);
    EXPECT_GE(listener_.counter("damaged"), 1u) << bit;
  }
}

TEST_F(LogRecording, BadDescriptionsAndValuesAreCountedAndTheRestPlays) {
  Writer writer;
  join_mote(writer);
  for (const auto* bad : {"", "[]", "{", "7", "{\"sensors\":7,\"name\":[]}", "{\"sensors\":[7,null]}"})
    writer.describe("proxy.wsn-1.9.description", bad);
  writer.describe("proxy.wsn-1.7.sensor.light-1.description", std::string(100'000, '['));
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "bright");
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "nan");
  writer.set("proxy.wsn-1.7.sensor.light-1.value", "7");
  play(writer.file());
  EXPECT_THAT(delivered(), ElementsAre("7"));
  EXPECT_GE(listener_.counter("damaged"), 6u);
}

/// What a recorder wrote of a DUMMY sensor before illuminance became light, and of a table in Fahrenheit.
TEST_F(LogRecording, ARecordingOfFormerTypesAndOtherUnitsPlaysWithThoseOfToday) {
  Writer writer;
  writer.same_turn = true;
  writer.set("proxy.dummy-1.living.sensor.illuminance-1.value", "");
  writer.describe(
      "proxy.dummy-1.living.sensor.illuminance-1.description",
      R"({"type":"illuminance","type_id":1024,"quantity":"illuminance","unit":"lx","data_type":"real","minimum":0.0,"access":"read","report":"state","instance":"1"})");
  writer.set("proxy.dummy-1.living.sensor.temperature-1.value", "");
  writer.describe(
      "proxy.dummy-1.living.sensor.temperature-1.description",
      R"({"type":"temperature","type_id":2,"quantity":"temperature","unit":"[degF]","data_type":"real","minimum":-273.15,"maximum":212.0,"access":"read","report":"state","instance":"1"})");
  writer.describe(
      "proxy.dummy-1.living.description",
      R"({"name":"Living room","model":"","type":"","address":"living","network":"dummy-1","capabilities":["illuminance","temperature"],"sensors":["illuminance-1","temperature-1"],"actuators":[],"properties":[]})");
  writer.same_turn = false;
  writer.set("proxy.dummy-1.living.sensor.illuminance-1.value", "52.5");
  writer.set("proxy.dummy-1.living.sensor.temperature-1.value", "71.6");
  play(writer.file());
  const auto joined = joins();
  ASSERT_EQ(joined.size(), 1u);
  const auto& capabilities = joined[0].capabilities;
  ASSERT_EQ(capabilities.size(), 2u);
  EXPECT_EQ(capabilities[0].point, (model::PointId{Kind::kSensor, TypeId{1}, "1"}));
  EXPECT_EQ(capabilities[0].type_name, "light");
  EXPECT_EQ(capabilities[1].unit, "");
  EXPECT_FALSE(capabilities[1].minimum) << "as the type says";
  EXPECT_EQ(capabilities[1].maximum, 100.0);
  const auto readings = listener_.readings();
  ASSERT_EQ(readings.size(), 2u);
  EXPECT_EQ(readings[0].point, capabilities[0].point);
  EXPECT_THAT(delivered(), ElementsAre("52.5", "22"));
}

TEST(RecordedValues, ComeBackWithTheTextTheyHad) {
  const TypeCatalogue types;
  const auto text = [&](const char* type, std::string_view recorded) {
    const auto value = recorded_value(types.find(type), recorded, "text/plain");
    return value ? model::to_text(*value) : "error " + value.error().text;
  };
  for (const auto* number : {"21.5", "100000", "1e+05", "-0.001", "9007199254740993", "0", "5e-324"}) {
    EXPECT_EQ(text("temperature", number), number);
  }
  EXPECT_EQ(recorded_value(types.find("contact"), "open", "text/plain"), Value(true));
  EXPECT_EQ(recorded_value(nullptr, "on", "text/plain"), Value(std::string("on")));
  EXPECT_EQ(recorded_value(nullptr, "[1]", "application/json"), Value(Json{"[1]"}));
  EXPECT_THAT(text("temperature", "warm"), HasSubstr("is not a number"));
  EXPECT_THAT(text("temperature", "inf"), HasSubstr("is not a number"));
  EXPECT_THAT(text("temperature", ""), HasSubstr("is not a number"));
}

TEST(RecordedValues, EnumerationsAndSetsOfBitsAreReadAsWordsAndAsTheNumbersOfOlderRecordings) {
  const TypeCatalogue types;
  const auto* mode = types.find("enumerationInput");
  EXPECT_EQ(recorded_value(mode, "heat", "text/plain"), Value(std::string("heat")));
  EXPECT_EQ(recorded_value(mode, "1", "text/plain"), Value(std::int64_t{1}));
  const auto* flags = types.find("bitsetInput");
  EXPECT_EQ(recorded_value(flags, "16641", "text/plain"), Value(Json{"16641"}));
  EXPECT_EQ(recorded_value(flags, R"({"raw":1})", "application/json"), Value(Json{R"({"raw":1})"}));
}

TEST(RecordedDevices, WordsOfAPointComeBackWithTheirNumbers) {
  const TypeCatalogue types;
  ForeignTypes foreign(types);
  PointDescriptions descriptions;
  const auto words = [&](std::string_view rest) {
    RecordedPoint point;
    point.id = "enumerationInput-1";
    EXPECT_TRUE(describe(point, R"({"type":"enumerationInput","type_id":275,)" + std::string(rest) + "}", foreign,
                         descriptions));
    return point.capability.words;
  };
  for (int of_two = 0; of_two < 2; ++of_two) {  // points with one description
    EXPECT_EQ(words(R"("words":["auto","heat"])"), (std::vector<model::Word>{{0, "auto"}, {1, "heat"}}));
  }
  EXPECT_EQ(words(R"("words":["auto","no demand"],"codes":[0,20])"),
            (std::vector<model::Word>{{0, "auto"}, {20, "no demand"}}));
  EXPECT_THAT(words(R"("words":["auto","no demand"],"codes":[0,"x"])"), IsEmpty());
  EXPECT_THAT(words(R"("minimum":0)"), IsEmpty());
}

TEST(RecordedDevices, APointOfAnOpenTypeIsReadAsItDescribesItself) {
  const TypeCatalogue types;
  ForeignTypes foreign(types);
  PointDescriptions descriptions;
  RecordedPoint lid;
  lid.id = "lid-1";
  const auto id = std::to_string(static_cast<unsigned>(model::open_type("lid")));
  ASSERT_TRUE(describe(lid,
                       R"({"type":"lid","type_id":)" + id +
                           R"(,"data_type":"boolean","unit":"1","words":["CLOSED","OPEN"],"report":"event"})",
                       foreign, descriptions));
  EXPECT_EQ(lid.capability.point.type, model::open_type("lid"));
  EXPECT_EQ(lid.capability.data, model::DataType::kBoolean);
  EXPECT_EQ(lid.capability.report, model::Report::kEvent);
  EXPECT_EQ(lid.capability.words, (std::vector<model::Word>{{0, "CLOSED"}, {1, "OPEN"}}));
  EXPECT_EQ(recorded_value(lid.type, "OPEN", "text/plain"), Value(true));
  ASSERT_TRUE(describe(lid, R"({"type":"lid","type_id":)" + id + R"(,"data_type":"unknown"})", foreign, descriptions));
  EXPECT_EQ(lid.type, nullptr);
  EXPECT_EQ(recorded_value(lid.type, "OPEN", "text/plain"), Value(std::string("OPEN")));
}

TEST(RecordedDevices, PointsJoinInAnOrderThatGivesTheSameCapabilities) {
  const TypeCatalogue types;
  ForeignTypes foreign(types);
  RecordedDevice device;
  ASSERT_TRUE(describe(device, R"({"capabilities":["switch","light","rate","temperature"],)"
                               R"("sensors":["light-1","light-2","temperature-1"],"actuators":["switch-1","light-9"],)"
                               R"("properties":["rate"]})"));
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (const auto& id : device.listed[kind]) {
      auto& point = device.points[{static_cast<Kind>(kind), id}];
      point.kind = static_cast<Kind>(kind);
      point.id = id;
    }
  }
  std::vector<std::string> order;
  for (const auto& capability : join_of(device, foreign).capabilities) {
    if (std::find(order.begin(), order.end(), capability.type_name) == order.end())
      order.push_back(capability.type_name);
  }
  EXPECT_THAT(order, ElementsAre("switch", "light", "rate", "temperature"));
}

TEST(RecordedDevices, ForeignTypesGetTheirRecordedNumberWhileItIsFree) {
  const TypeCatalogue types;
  ForeignTypes foreign(types);
  TypeId first{0x9001}, second{0x9001}, taken = types.find("light")->id, again{};
  EXPECT_EQ(foreign.find("mood", first), nullptr);
  EXPECT_EQ(first, TypeId{0x9001});
  EXPECT_EQ(foreign.find("other", second), nullptr);
  EXPECT_NE(second, TypeId{0x9001});
  EXPECT_EQ(foreign.find("third", taken), nullptr);
  EXPECT_EQ(types.find(taken), nullptr);
  EXPECT_EQ(foreign.find("mood", again), nullptr);
  EXPECT_EQ(again, first);
}

}  // namespace
}  // namespace rubicon::networks::log
