#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "networks/salad/properties_reader.h"
#include "networks/salad/salad_options.h"
#include "support/config_text.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::salad {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> pairs_of(std::string_view text) {
  std::vector<std::string> pairs;
  for (const auto& [line, key, value, fault] : read_properties(text))
    pairs.push_back(std::to_string(line) + " " + key + "=" + value + (fault.empty() ? "" : "!"));
  return pairs;
}

TEST(Properties, KeysEndAtEqualsColonOrBlank) {
  EXPECT_THAT(pairs_of("a=1\nb:2\nc 3\nd = 4\n\te\t:\t5\nf==6\ng\nh=\ni  = : 7"),
              ElementsAre("1 a=1", "2 b=2", "3 c=3", "4 d=4", "5 e=5", "6 f==6", "7 g=", "8 h=", "9 i=: 7"));
}

TEST(Properties, CommentsAndEmptyLinesAreNothing) {
  EXPECT_THAT(pairs_of("# a=1\n  ! b=2\n\n \t\nc=3 # not a comment\n#continued \\\nd=4"),
              ElementsAre("5 c=3 # not a comment", "7 d=4"));
}

TEST(Properties, LinesEndAsOnAnySystem) {
  EXPECT_THAT(pairs_of("a=1\rb=2\r\nc=3\n\rd=4"), ElementsAre("1 a=1", "2 b=2", "3 c=3", "5 d=4"));
  EXPECT_THAT(pairs_of("\xef\xbb\xbf"
                       "a=1"),
              ElementsAre("1 a=1"));
  EXPECT_THAT(pairs_of(""), IsEmpty());
}

TEST(Properties, ABackslashAtTheEndContinuesTheLine) {
  EXPECT_THAT(pairs_of("device_7 = FRIDGE,\\\n    sensor.switch\nb=2"),
              ElementsAre("1 device_7=FRIDGE,sensor.switch", "3 b=2"));
  EXPECT_THAT(pairs_of("a=1\\\n#2\\\r\n  3"), ElementsAre("1 a=1#23"));
  EXPECT_THAT(pairs_of("a=1\\\\\nb=2"), ElementsAre("1 a=1\\", "2 b=2"));
  EXPECT_THAT(pairs_of("a=1\\"), ElementsAre("1 a=1"));
}

TEST(Properties, EscapesStandForTheirCharacters) {
  EXPECT_THAT(pairs_of("a\\ b\\=c=\\t\\n\\r\\f\\q\\\\\\u0041"), ElementsAre("1 a b=c=\t\n\r\fq\\A"));
  EXPECT_THAT(pairs_of("a=\\u00e9\\u20ac\\ud83d\\ude00\\ud83d!"),
              ElementsAre("1 a=\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80\xef\xbf\xbd!"));
  EXPECT_THAT(pairs_of("a=\xe9"), ElementsAre("1 a=\xc3\xa9")) << "ISO 8859-1";
  for (const auto* text : {"a=\\u12", "a=\\uxyz1", "a=\\u"}) EXPECT_THAT(pairs_of(text)[0], ::testing::EndsWith("!"));
}

class SaladFile : public ::testing::Test {
 protected:
  SaladOptions read(std::string_view file, std::string_view options = R"({"properties": "salad.properties"})") {
    files.put("site/salad.properties", file);
    return read_options(options);
  }
  SaladOptions read_options(std::string_view json) {
    const auto node = support::config_of(json);
    ConfigReader reader(node, "networks.salad", errors);
    auto options = read_salad_options({"salad", IslandId{1}, reader, types, "site"}, files);
    reader.finish();
    return options;
  }

  TypeCatalogue types;
  transport::MemoryTransports files;
  ConfigErrors errors;
};

TEST_F(SaladFile, TheFlatIsReadAsItIs) {
  const auto node = support::config_of(std::string_view(R"({"properties": "salad.properties"})"));
  ConfigReader reader(node, "", errors);
  transport::MemoryTransports disk;
  std::ifstream flat(RUBICON_SOURCE_DIR "/examples/salad.properties");
  disk.put("salad.properties", std::string(std::istreambuf_iterator<char>(flat), {}));
  const auto options = read_salad_options({"salad", IslandId{1}, reader, types, ""}, disk);
  EXPECT_THAT(errors.text(), "");
  ASSERT_EQ(options.devices.size(), 55u);
  std::map<std::string, int> of_type;
  std::vector<int> actuatable;
  for (const auto& [id, device] : options.devices) {
    ++of_type[device.type];
    if (!device.actuator.empty()) actuatable.push_back(id);
  }
  EXPECT_THAT(of_type, ElementsAre(std::pair("actuator.light", 2), std::pair("actuator.relay", 3),
                                   std::pair("actuator.status", 1), std::pair("sensor.motion", 4),
                                   std::pair("sensor.pressure", 3), std::pair("sensor.soundrecognition", 13),
                                   std::pair("sensor.soundrecognition.confidence", 14), std::pair("sensor.status", 3),
                                   std::pair("sensor.switch", 12)));
  EXPECT_THAT(actuatable, ElementsAre(28, 46, 47, 65, 66, 67, 70));
  EXPECT_THAT(options.unknown_keys, IsEmpty());
}

TEST_F(SaladFile, AllKeysOfTheOriginalAreKnown) {
  const auto options = read(
      "name=salad\nsalad_host = 192.168.1.141 \nsalad_port=9001\nrubicon_port=9101\n"
      "socket_accept_timeout_milliseconds=10000\nsocket_init_retry_milliseconds=2000\n"
      "socket_buffer_size_bytes=1024\ndevice_7=FRIDGE,sensor.switch\nfoo=bar\n");
  EXPECT_EQ(errors.text(), "");
  EXPECT_EQ(options.host, "192.168.1.141");
  EXPECT_EQ(options.port, 9001);
  EXPECT_EQ(options.own_port, 9101);
  EXPECT_EQ(options.buffer, 1024u);
  EXPECT_THAT(options.unknown_keys, ElementsAre("foo"));
  EXPECT_EQ(options.devices.at(7).name, "FRIDGE");
}

TEST_F(SaladFile, TheConfigurationSaysTheSameAndGoesBeforeTheFile) {
  const auto options = read("salad_host=a\nsalad_port=9001\ndevice_7=FRIDGE,sensor.switch\n",
                            R"({"properties": "salad.properties", "salad_host": "b", "any_source": "yes",
                                "start-again-after": "never", "rubicon_port": 0,
                                "table": {"28": ["TV_STATE", "sensor.status", "LG"], "8": "CHAIR, sensor.pressure"}})");
  EXPECT_EQ(errors.text(), "");
  EXPECT_EQ(options.host, "b");
  EXPECT_EQ(options.port, 9001);
  EXPECT_EQ(options.own_port, 0);
  EXPECT_TRUE(options.any_source);
  EXPECT_FALSE(options.start_again);
  EXPECT_EQ(options.devices.size(), 3u);
  EXPECT_EQ(options.devices.at(28).actuator, "LG");
  EXPECT_TRUE(options.devices.at(28).sensor);
  EXPECT_EQ(options.devices.at(8).type, "sensor.pressure");
}

TEST_F(SaladFile, TheDefaultsAreTheOriginals) {
  const auto options = read_options(R"({"table": {"1": "A,sensor.switch"}})");
  EXPECT_EQ(options.host, "localhost");
  EXPECT_EQ(options.port, 9000);
  EXPECT_EQ(options.own_port, 9100);
  EXPECT_EQ(options.buffer, 2048u);
  EXPECT_FALSE(options.any_source);
}

TEST_F(SaladFile, TokensAreTrimmedAndCommasCollapse) {
  const auto device = read_device(" TV_STATE ,, sensor.status ,,, LG ,", types);
  ASSERT_TRUE(device) << device.error().text;
  EXPECT_EQ(device->name, "TV_STATE");
  EXPECT_EQ(device->type, "sensor.status");
  EXPECT_EQ(device->actuator, "LG");
}

TEST_F(SaladFile, EachTypeOfTheFlatHasItsTypeInTheCatalogue) {
  const std::pair<const char*, const char*> kTypes[] = {
      {"sensor.switch", "switch"},
      {"sensor.motion", "motion"},
      {"sensor.pressure", "pressureRaw"},
      {"sensor.soundrecognition", "soundRecognition"},
      {"sensor.soundrecognition.confidence", "soundRecognitionConfidence"},
      {"sensor.status", "status"},
      {"actuator.light", "lamp"},
      {"actuator.relay", "relay"},
      {"actuator.status", "status"},
      {"sensor.temperature", "temperature"},
      {"actuator.dimmer", "dimmer"}};
  for (const auto& [salad, catalogue] : kTypes) {
    const auto device = read_device(std::string("X,") + salad, types);
    ASSERT_TRUE(device) << salad;
    EXPECT_EQ(types.find(device->type_id)->name, catalogue);
    EXPECT_EQ(device->sensor, std::string_view(salad).starts_with("sensor."));
  }
}

struct Wrong {
  const char *line, *expected;
};

class WrongLine : public SaladFile, public ::testing::WithParamInterface<Wrong> {};

TEST_P(WrongLine, IsRejectedWithItsPlace) {
  static_cast<void>(read(std::string("# flat\ndevice_1=A,sensor.switch\n") + GetParam().line + "\n"));
  ASSERT_EQ(errors.lines().size(), 1u) << errors.text();
  EXPECT_THAT(errors.text(), ::testing::StartsWith("site/salad.properties:3:1: "));
  EXPECT_THAT(errors.text(), HasSubstr(GetParam().expected));
}

constexpr Wrong kWrong[] = {
    {"device_7=", "its name is missing"},
    {"device_7", "its name is missing"},
    {"device_7=,,,", "its name is missing"},
    {"device_7= ,sensor.switch", "its type is missing"},
    {"device_7=FRIDGE", "its type is missing"},
    {"device_7=FRIDGE, ", "its type is missing"},
    {"device_7=FRIDGE, ,LG", "its type is missing"},
    {"device_7=FRIDGE,sensor.switch,LG,4", "has 4 parts"},
    {"device_0=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_65536=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_-1=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_x=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_99999999999999999999=FRIDGE,sensor.switch", "expected a device id from 1 to 65535"},
    {"device_1=FRIDGE,sensor.switch", "device 1 is already defined at site/salad.properties:2:1"},
    {"device_01=FRIDGE,sensor.switch", "device 1 is already defined"},
    {"device_7=FRI.DGE,sensor.switch", "its name is 'FRI.DGE'"},
    {"device_7=FRI DGE,sensor.switch", "its name is 'FRI DGE'"},
    {"device_7=K\xdcHLSCHRANK,sensor.switch", "its name is"},
    {"device_7=FRIDGE,sensor.fridge", "expected one of: sensor.switch"},
    {"device_7=FRIDGE,switch", "expected one of: sensor.switch"},
    {"device_7=FRIDGE,sensor.switch,a:b", "its actuator id is 'a:b'"},
    {"device_7=FRIDGE,sensor.switch,a#b", "its actuator id is"},
    {"device_7=FRIDGE,sensor.switch, ", "its actuator id is"},
    {"device_7=\\u12", "four hexadecimal digits"},
    {"salad_port=0", "salad_port: is '0'"},
    {"salad_port=x", "salad_port: is 'x'"},
    {"rubicon_port=70000", "rubicon_port: is '70000'"},
    {"socket_buffer_size_bytes=1", "socket_buffer_size_bytes: is '1'"},
    {"salad_host=", "salad_host: expected a host name or an address"},
};
INSTANTIATE_TEST_SUITE_P(Of, WrongLine, ::testing::ValuesIn(kWrong),
                         [](const auto& one) { return std::to_string(one.index); });

TEST_F(SaladFile, WhatIsWrongInTheConfigurationIsSaidThere) {
  static_cast<void>(read_options(
      R"({"table": {"0": "A,sensor.switch", "1": {"name": "A"}, "2": ["A", ["B"]], "3": "A"}, "any_source": "perhaps",
          "start-again-after": "1ms", "salad_hots": "x", "properties": "nowhere.properties"})"));
  for (const auto* part :
       {"table.0: is '0'", "table.1: expected name, type", "table.2: expected name, type",
        "table.3: its type is missing", "any_source: is 'perhaps'", "start-again-after: expected at least",
        "unknown key 'salad_hots'", "nowhere.properties: cannot open"}) {
    EXPECT_THAT(errors.text(), HasSubstr(part));
  }
  errors = {};
  static_cast<void>(read_options("{}"));
  EXPECT_THAT(errors.text(), HasSubstr("no devices"));
  errors = {};
  static_cast<void>(read(std::string((1 << 20) + 1, '#')));
  EXPECT_THAT(errors.text(), HasSubstr("bytes, expected at most 1048576"));
}

TEST_F(SaladFile, ADeviceInBothIsThereTwice) {
  static_cast<void>(read("device_7=FRIDGE,sensor.switch",
                         R"({"properties": "salad.properties", "table": {"7": "FRIDGE,sensor.switch"}})"));
  EXPECT_THAT(errors.text(), HasSubstr("table.7: device 7 is already defined at site/salad.properties:1:1"));
}

}  // namespace
}  // namespace rubicon::networks::salad
