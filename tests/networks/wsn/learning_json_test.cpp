#include "networks/wsn/mote_messages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "motes/learning_records.h"

namespace rubicon::networks::wsn {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

std::string error_of(std::string_view json) {
  const auto message = learning_message(json);
  return message ? "" : message.error().text;
}

motes::NetMessage message_to(std::uint16_t mote, const LearningMessage& message) {
  return {11, mote, 11, 5, 0, 1, 0, message.transport, message.application, message.record};
}

TEST(LearningJson, ACommandHasTheBytesOfTheOriginal) {
  const auto message = learning_message(R"({"record": "NetIdCmd", "command": 1, "netId": 300, "seq": 48879})");
  ASSERT_TRUE(message.has_value()) << message.error().text;
  EXPECT_EQ(*message, (LearningMessage{3, 6, hex("01 012c beef")}));
  EXPECT_EQ(learning_json(message_to(5, *message)), R"({"record":"NetIdCmd","command":1,"netId":300,"seq":48879})");
}

TEST(LearningJson, FloatsAreShownAsShortAsTheyCanBeRead) {
  const auto message = learning_message(R"({"record": "LearningOutputMsg", "floats": [0.1, -1.5, 3e38, 1e-45]})");
  ASSERT_TRUE(message.has_value()) << message.error().text;
  EXPECT_EQ(base::to_hex(ByteView(message->record).first(10)),
            "1904cdcccc3d0000c0bf"
            "");
  EXPECT_EQ(learning_json(message_to(motes::kBaseMote, *message)),
            R"({"record":"LearningOutput","type":25,"count":4,"floats":[0.1,-1.5,3e+38,1e-45]})");
}

TEST(LearningJson, TheLargestFloatsReadBack) {
  Bytes largest = hex("19 02 ffff7fff ffff7f7f");
  largest.resize(98);
  const LearningMessage message{3, 6, largest};
  const auto json = learning_json(message_to(motes::kBaseMote, message));
  ASSERT_TRUE(json.has_value());
  const auto read_back = learning_message(*json);
  ASSERT_TRUE(read_back.has_value()) << read_back.error().text;
  EXPECT_EQ(*read_back, message);
}

TEST(LearningJson, ARecordWithAFixedTypeAcceptsNoOther) {
  EXPECT_TRUE(learning_message(R"({"record":"LearningOutput","type":25,"floats":[0.75]})"));
  const auto refused = learning_message(R"({"record":"LearningOutput","type":12,"floats":[0.75]})");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text, "mote record LearningOutput: type is 12, expected 25");
}

TEST(LearningJson, SynapticRecordsGoToTheirOwnApplication) {
  const auto message = learning_message(R"({"record": "SynData", "floats": [0.75]})");
  ASSERT_TRUE(message.has_value()) << message.error().text;
  EXPECT_EQ(message->transport, 1);
  EXPECT_EQ(message->application, 11);
  EXPECT_EQ(message->record.size(), 40u);
  EXPECT_EQ(learning_json(message_to(5, *message)),
            R"({"record":"SynData","floats":[0.75,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0]})");
}

TEST(LearningJson, TransportAndApplicationMayBeGiven) {
  const auto message = learning_message(
      R"({"record": "BroadcastCmd", "type": 8, "clock": 500, "seq": 7, "transport": 9, "application": 255})");
  ASSERT_TRUE(message.has_value()) << message.error().text;
  EXPECT_EQ(*message, (LearningMessage{9, 255, hex("08 01f4 0007")}));
  EXPECT_EQ(error_of(R"({"record": "RAddr", "pid": 11, "devid": 5, "transport": 3})"),
            "mote record RAddr: application is missing, expected 1 to 255");
  EXPECT_EQ(error_of(R"({"record": "RAddr", "pid": 11, "devid": 5, "transport": 3, "application": 6})"), "");
}

TEST(LearningJson, EveryRecordIsWrittenAndReadBackTheSame) {
  const std::string zeros = [](std::size_t count) {
    std::string text = "1";
    for (std::size_t i = 1; i < count; ++i) text += ",0";
    return text;
  }(92);
  const std::pair<std::uint16_t, std::string> messages[] = {
      {5, R"({"record":"NetIdCmd","command":7,"netId":65535,"seq":0})"},
      {5, R"({"record":"BroadcastCmd","type":8,"clock":500,"seq":7})"},
      {5, R"({"record":"SynCreateCmd","type":9,"srcIsland":11,"srcMote":2,"destIsland":12,"destMote":3,"srcNetId":300,)"
          R"("destNetId":301,"srcCount":2,"srcNeurons":[1,258],"destCount":0,"destNeurons":[],"params":-128,"seq":1})"},
      {5, R"({"record":"LearningModuleCmd","type":12,"netId":1,"seq":2,"rows":3,"cols":4,"size":5,"weights":[)" +
              zeros + "]}"},
      {motes::kBaseMote,
       R"({"record":"LearningModuleDown","type":24,"netId":1,"size":0,"floats":[)"
       R"(0.1,0.2,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,-0.5]})"},
      {motes::kBaseMote, R"({"record":"LearningOutput","type":25,"count":1,"floats":[1.5]})"},
  };
  for (const auto& [mote, json] : messages) {
    const auto message = learning_message(json);
    ASSERT_TRUE(message.has_value()) << message.error().text;
    EXPECT_EQ(learning_json(message_to(mote, *message)), json);
  }
}

TEST(LearningJson, AnUploadOfFloatsIsReportedAsWeightsOfTheSameBytes) {
  const auto floats = learning_message(
      R"({"record":"LearningModuleFloatCmd","type":12,"netId":1,"seq":2,"rows":3,"cols":4,"size":8,"floats":[0.1,2]})");
  ASSERT_TRUE(floats.has_value()) << floats.error().text;
  const auto json = learning_json(message_to(5, *floats));
  ASSERT_TRUE(json.has_value());
  EXPECT_THAT(*json, StartsWith(R"({"record":"LearningModuleCmd")"));
  EXPECT_EQ(learning_message(*json).value(), *floats);
}

TEST(LearningJson, WhatDoesNotFitIsRefusedWithAReason) {
  EXPECT_EQ(error_of(""), "a message to a mote is not valid JSON");
  EXPECT_EQ(error_of("{\"record\":"), "a message to a mote is not valid JSON");
  EXPECT_EQ(error_of("[1]"), "a message to a mote is not a JSON object");
  EXPECT_EQ(error_of("{}"), "a message to a mote has no \"record\", expected the name of a record");
  EXPECT_EQ(error_of(R"({"record": 17})"), "a message to a mote has no \"record\", expected the name of a record");
  EXPECT_THAT(error_of(R"({"record": "Nonsense"})"),
              StartsWith("unknown mote record \"Nonsense\", expected one of Command,"));
  EXPECT_EQ(error_of(R"({"record": "CommandMsg", "command": 1, "counter": 1, "delay": 1})"),
            "mote record Command: is a packet of its own (type 11), not part of a radio message");
}

TEST(LearningJson, MembersThatDoNotFitAreNamed) {
  const auto with = [](std::string_view rest) {
    return error_of(fmt::format(R"({{"record": "NetIdCmd", "command": 1, "netId": 300, {}}})", rest));
  };
  EXPECT_EQ(with(R"("seq": 7)"), "");
  EXPECT_EQ(with(R"("seq": 65536)"), "mote record NetIdCmd: seq is 65536, expected a whole number from 0 to 65535");
  EXPECT_EQ(with(R"("seq": 1.5)"), "mote record NetIdCmd: seq is 1.5, expected a whole number from 0 to 65535");
  EXPECT_THAT(with(R"("seq": 99999999999999999999999)"), HasSubstr("seq is 1e+23, expected a whole number"));
  EXPECT_EQ(with(R"("seq": "7")"), "mote record NetIdCmd: seq is \"7\", expected a number");
  EXPECT_EQ(with(R"("seq": true)"), "mote record NetIdCmd: seq is true, expected a number");
  EXPECT_EQ(with(R"("seq": [7])"), "mote record NetIdCmd: seq is an array, expected a number");
  EXPECT_EQ(with(R"("seq": null)"), "mote record NetIdCmd: seq is null, expected a number");
  EXPECT_EQ(with(R"("seq": 7, "clock": 1)"),
            "mote record NetIdCmd: unknown field \"clock\", expected command, netId, seq");
  EXPECT_EQ(with(R"("transport": 3)"), "mote record NetIdCmd: seq is missing, expected a number from 0 to 65535");
  for (const char* wrong : {"0", "256", "-1", "1.0", "\"3\"", "[3]"}) {
    EXPECT_THAT(with(fmt::format(R"("seq": 7, "transport": {})", wrong)),
                HasSubstr("expected a whole number from 1 to 255"));
  }
}

TEST(LearningJson, ArraysThatDoNotFitAreNamed) {
  EXPECT_EQ(error_of(R"({"record": "LearningOutput", "floats": [1, "2"]})"),
            "mote record LearningOutput: floats[] is \"2\", expected a number");
  EXPECT_EQ(error_of(R"({"record": "LearningOutput", "floats": {}})"),
            "mote record LearningOutput: floats is an object, expected an array of numbers");
  EXPECT_EQ(error_of(R"({"record": "LearningOutput", "count": 2, "floats": [1]})"),
            "mote record LearningOutput: count is 2, expected 1, the number of elements");
  std::string many = "0";
  for (int i = 0; i < 24; ++i) many += ",0";
  EXPECT_EQ(error_of(fmt::format(R"({{"record": "LearningOutput", "floats": [{}]}})", many)),
            "mote record LearningOutput: floats has 25 elements, expected at most 24");
}

TEST(LearningJson, DeepAndLongTextsAreSurvived) {
  EXPECT_NE(error_of(std::string(100'000, '[')), "");
  EXPECT_NE(error_of(R"({"record": "NetIdCmd", "seq": )" + std::string(50'000, '[') + std::string(50'000, ']') + "}"),
            "");
  EXPECT_LT(error_of(R"({"record": ")" + std::string(100'000, 'x') + "\"}").size(), 400u);
  EXPECT_LT(error_of(R"({"record": "NetIdCmd", ")" + std::string(100'000, 'x') + "\": 1}").size(), 400u);
  EXPECT_EQ(error_of("{\"record\": \"NetIdCmd\", \"caf\u00e9\": 1}"),
            "mote record NetIdCmd: unknown field \"caf\u00e9\", expected command, netId, seq");
  EXPECT_THAT(error_of("{\"record\": \"caf\u00e9\"}"), StartsWith(R"(unknown mote record "caf\u00e9", expected)"));
}

/// The longest text that another program may send, full of members. tests/structure holds the parser to maps.
TEST(LearningJson, ATextOfManyMembersIsReadWhole) {
  std::string text = R"({"record": "NetIdCmd", "command": 1, "netId": 300, "seq": 48879)";
  for (int i = 0; text.size() < 256 * 1024; ++i) text += fmt::format(",\"x{:x}\":0", i);
  EXPECT_EQ(error_of(text + "}"), "mote record NetIdCmd: unknown field \"x0\", expected command, netId, seq");
  EXPECT_EQ(error_of(text + R"(,"seq": [1]})"), "mote record NetIdCmd: seq is an array, expected a number");
}

TEST(LearningJson, WhatIsNoNumberIsShownAsNull) {
  const LearningMessage message{3, 6, hex("19 02 0000c07f 0000803f")};
  EXPECT_EQ(learning_json(message_to(motes::kBaseMote, message)),
            R"({"record":"LearningOutput","type":25,"count":2,"floats":[null,1.0]})");
}

TEST(LearningJson, OtherMessagesHaveNone) {
  EXPECT_EQ(learning_json(message_to(5, {3, 5, hex("01 012c beef")})), std::nullopt);
  EXPECT_EQ(learning_json(message_to(5, {3, 6, hex("01 012c be")})), std::nullopt);
  EXPECT_EQ(learning_json(message_to(5, {3, 6, hex("ff 012c beef")})), std::nullopt);
  EXPECT_EQ(learning_json(message_to(5, {3, 6, {}})), std::nullopt);
}

}  // namespace
}  // namespace rubicon::networks::wsn
