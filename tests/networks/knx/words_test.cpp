#include <nlohmann/json.hpp>

#include "networks/knx/bench.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class KnxWords : public KnxBench {
 protected:
  Result<void> command(const std::string& device, const PointId& to, Value value) {
    return send(model::Actuate{5, to, std::move(value)}, device);
  }
};

/// Modes, sets of bits and a percentage, each commanded and reported.
constexpr std::string_view kModes = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
  "3/0/1": {"dpt": "20.105", "kind": "actuator", "state": "3/0/2"},
  "3/0/3": {"dpt": "22.101"},
  "3/0/4": {"dpt": "21.002", "kind": "actuator"},
  "3/0/5": {"dpt": "20.006"}, "3/0/6": {"dpt": "20.102", "kind": "actuator"},
  "3/0/7": {"dpt": "9.001", "kind": "actuator"}, "3/0/8": {"dpt": "5.001"}, "3/0/9": {"dpt": "14.056"},
  "3/0/10": {"dpt": "9.027", "kind": "actuator"}, "3/0/11": {"dpt": "20.102"}}})";

TEST_F(KnxWords, EnumerationsAndSetsOfBitsAreWords) {
  start(kModes);
  server.inject(0x1105, group("3/0/2"), 0x80, {1});
  server.inject(0x1105, group("3/0/2"), 0x80, {18});
  server.inject(0x1105, group("3/0/3"), 0x80, {0x00, 0x81});
  server.inject(0x1105, group("3/0/5"), 0x80, {20});
  server.inject(0x1105, group("3/0/11"), 0x80, {2});
  server.inject(0x1105, group("3/0/11"), 0x80, {5});  // a vendor's
  host.time.run_for(1s);
  EXPECT_THAT(values_of("3/0/11"), ElementsAre("standby", "5"));
  EXPECT_THAT(values_of("3/0/1"), ElementsAre("heat", "18")) << "18 has no word";
  EXPECT_THAT(values_of("3/0/5"), ElementsAre("lighting"));
  const auto status = nlohmann::json::parse(values_of("3/0/3").at(0));
  EXPECT_EQ(status["raw"], 0x81);
  EXPECT_EQ(status["fault"], true);
  EXPECT_EQ(std::count(status.begin(), status.end(), nlohmann::json(true)), 2);
}

TEST_F(KnxWords, WordsAndNumbersCommandThem) {
  start(kModes);
  const auto mode = point(Kind::kActuator, "enumerationOutput");
  for (const Value& value : {Value(std::string("heat")), Value(std::int64_t{1})}) {
    ASSERT_TRUE(command("3/0/1", mode, value));
    host.time.run_for(1s);
  }
  EXPECT_EQ(telegrams("3/0/1", {0x00, 0x80, 1}), 2);
  const auto control = point(Kind::kActuator, "bitsetOutput");
  for (const Value& value : {Value(Json{R"({"raw":4,"verify mode":true})"}), Value(std::int64_t{4})}) {
    ASSERT_TRUE(command("3/0/4", control, value));
    host.time.run_for(1s);
  }
  EXPECT_EQ(telegrams("3/0/4", {0x00, 0x80, 4}), 2);
  const auto hvac = point(Kind::kActuator, "hvacMode");
  for (const Value& value : {Value(std::string("comfort")), Value(std::int64_t{5})}) {
    ASSERT_TRUE(command("3/0/6", hvac, value));
    host.time.run_for(1s);
  }
  EXPECT_EQ(telegrams("3/0/6", {0x00, 0x80, 1}), 1);
  EXPECT_EQ(telegrams("3/0/6", {0x00, 0x80, 5}), 1);
  const auto refused = command("3/0/1", mode, std::string("heet"));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("'heet' is not one of"));
}

/// The device of D1.4, figure 3.1: an output register of 8 bits.
TEST_F(KnxWords, AnOutputRegisterIsSetByWholeNumbersAndReportsThem) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/4/6": {"dpt": "5.*", "kind": "actuator", "state": "1/4/7", "device": "1.4.6"}}})");
  const auto joins = host.all<model::Join>();
  ASSERT_EQ(joins.size(), 1U);
  EXPECT_EQ(joins[0].first, "1.4.6");
  const auto output = point(Kind::kActuator, "unsigned8BitOutput");
  EXPECT_EQ(joins[0].second.capabilities.at(0).point, output);
  for (const auto value : {0, 200, 255}) {
    ASSERT_TRUE(command("1.4.6", output, std::int64_t{value}));
    host.time.run_for(1s);
    EXPECT_EQ(telegrams("1/4/6", {0x00, 0x80, static_cast<std::uint8_t>(value)}), 1) << value;
  }
  server.inject(0x1105, group("1/4/7"), 0x80, {0xc8});
  host.time.run_for(1s);
  EXPECT_EQ(values_of("1.4.6").back(), "200") << "a whole number, no percentage";
  EXPECT_FALSE(command("1.4.6", output, std::int64_t{256}));
  EXPECT_FALSE(command("1.4.6", output, std::int64_t{-1}));
}

TEST_F(KnxWords, TheJoinNamesWordsAndBounds) {
  start(kModes);
  std::map<std::string, Capability> of;
  for (const auto& [device, join] : host.all<model::Join>()) of[device] = join.capabilities.at(0);
  const auto word = [&](const std::string& device, std::size_t place) {
    const auto& one = of[device].words.at(place);
    return std::to_string(one.value) + " " + one.text;
  };
  EXPECT_EQ(word("3/0/1", 1), "1 heat");
  EXPECT_EQ(word("3/0/1", 18), "20 no demand");
  EXPECT_EQ(word("3/0/4", 2), "2 verify mode");
  EXPECT_THAT(of["3/0/6"].words, IsEmpty()) << "its type has its own";
  EXPECT_EQ(of["3/0/6"].maximum, 255) << "numbers without a word too";
  EXPECT_EQ(of["3/0/1"].maximum, 255);
  EXPECT_EQ(of["3/0/8"].minimum, 0) << "a percentage";
  EXPECT_EQ(of["3/0/8"].maximum, 100);
  EXPECT_EQ(of["3/0/7"].minimum, -273) << "of a command: what the telegram can hold";
  EXPECT_EQ(of["3/0/9"].maximum, std::nullopt) << "what a single can hold is no bound";
  EXPECT_EQ(of["3/0/10"].maximum, std::nullopt) << "that of its type is lower";
}

}  // namespace
}  // namespace rubicon::networks::knx
