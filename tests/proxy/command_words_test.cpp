#include "island.h"

namespace rubicon::proxy {
namespace {

/// Commands in the words and within the bounds that a point has beside those of its type.
class CommandsInWords : public Island {
 protected:
  std::vector<model::Actuate> actuated() { return hall().sent_bodies<model::Actuate>(); }
};

TEST_F(CommandsInWords, ACommandOutOfThePointsOwnRangeIsRefusedWithThatRange) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, kKnob));
  join.capabilities.back().minimum = 10;
  join.capabilities.back().maximum = 200;
  say("7", join);
  const std::string knob = "proxy.hall.7.actuator.knob-1.command";
  EXPECT_EQ(set(knob, "201").text, "knob: '201' is not a number from 10 to 200");
  EXPECT_EQ(set(knob, "256").text, "knob: '256' is not a number from 10 to 200") << "not that of the type";
  EXPECT_EQ(set(knob, "200").verdict, Verdict::kApplied);
}

TEST_F(CommandsInWords, AnEnumerationIsCommandedAndShownInTheWordsOfItsPoint) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, types.find("enumerationOutput")->id));
  join.capabilities.back().words = {{0, "auto"}, {1, "heat"}, {20, "no demand"}};
  join.capabilities.back().minimum = 0;
  join.capabilities.back().maximum = 255;
  say("7", join);
  const std::string mode = "proxy.hall.7.actuator.enumerationOutput-1";
  const auto about = json(mode + ".description");
  EXPECT_EQ(about["data_type"], "enumeration");
  EXPECT_EQ(about["words"], (std::vector<std::string>{"auto", "heat", "no demand"}));
  EXPECT_EQ(about["codes"], (std::vector<int>{0, 1, 20})) << "they do not count from 0 by 1";
  for (const auto* text : {"heat", "Heat", "1"}) {
    EXPECT_EQ(set(mode + ".command", text).verdict, Verdict::kApplied) << text;
    EXPECT_EQ(actuated().back().value, Value(std::string("heat"))) << text;
  }
  report("7", join.capabilities[0].point, std::string("heat"));
  EXPECT_EQ(command_state(mode), "confirmed");
  EXPECT_EQ(text(mode + ".value"), "heat");
  EXPECT_EQ(set(mode + ".command", "7").verdict, Verdict::kApplied) << "a number without a word";
  EXPECT_EQ(actuated().back().value, Value(std::int64_t{7}));
  EXPECT_EQ(set(mode + ".command", "heet").text,
            "enumerationOutput: 'heet' is not one of auto, heat, no demand, or a number");
  EXPECT_EQ(set(mode + ".command", "256").text, "enumerationOutput: '256' is not a number from 0 to 255");
}

TEST_F(CommandsInWords, AReadingOfAWordThatIsNotDeclaredIsShownAndMarked) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, kMood));
  join.capabilities.push_back(capability(Kind::kSensor, types.find("enumerationInput")->id));
  join.capabilities.back().words = {{0, "auto"}, {1, "heat"}};
  say("7", join);
  const std::string mood = "proxy.hall.7.actuator.mood-1", mode = "proxy.hall.7.sensor.enumerationInput-1";
  const auto reason = [this](const std::string& point) { return json(point + ".status")["reason"].get<std::string>(); };
  report("7", join.capabilities[0].point, std::string("dusk"));
  report("7", join.capabilities[1].point, std::int64_t{5});
  for (const auto& [point, value] : {std::pair(mood, "dusk"), std::pair(mode, "5")}) {
    EXPECT_EQ(text(point + ".value"), value);
    EXPECT_EQ(quality(point), "good");
    EXPECT_EQ(reason(point), std::string("'") + value + "' is not among the words of the point");
  }
  report("7", join.capabilities[0].point, std::string("night"));
  report("7", join.capabilities[1].point, std::string("heat"));
  EXPECT_EQ(reason(mood), "");
  EXPECT_EQ(reason(mode), "");
  report("7", join.capabilities[0].point, std::string());
  EXPECT_EQ(quality(mood), "bad") << "no word at all";
}

TEST_F(CommandsInWords, ADeviceWithFewerWordsThanItsTypeTakesThoseOnly) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, kMood));
  join.capabilities.back().words = {{1, "night"}};
  say("7", join);
  const std::string mood = "proxy.hall.7.actuator.mood-1";
  EXPECT_EQ(json(mood + ".description")["words"], std::vector<std::string>{"night"});
  EXPECT_EQ(set(mood + ".command", "day").verdict, Verdict::kRefused);
  EXPECT_EQ(set(mood + ".command", "0").text, "mood: '0' is not one of night");
  EXPECT_EQ(set(mood + ".command", "1").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated().back().value, Value(std::string("night")));
}

TEST_F(CommandsInWords, ANumberWithoutAWordIsTakenWithinTheBoundsOfThePointOnly) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, kMood));
  say("7", join);
  const std::string command = "proxy.hall.7.actuator.mood-1.command";
  EXPECT_EQ(set(command, "5").text, "mood: '5' is not one of day, night");
  join.capabilities.back().minimum = 0;
  join.capabilities.back().maximum = 255;
  say("7", join);
  EXPECT_EQ(set(command, "5").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated().back().value, Value(std::int64_t{5}));
  EXPECT_EQ(set(command, "256").text, "mood: '256' is not a number from 0 to 255");
  EXPECT_EQ(set(command, "cosy").verdict, Verdict::kRefused);
}

TEST_F(CommandsInWords, ASetOfBitsIsCommandedByNameAndConfirmedByItsFullForm) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, types.find("bitsetOutput")->id));
  join.capabilities.back().words = {{0, "fault"}, {1, "alarm"}};
  say("7", join);
  const std::string set_of_bits = "proxy.hall.7.actuator.bitsetOutput-1";
  EXPECT_EQ(json(set_of_bits + ".description")["words"], (std::vector<std::string>{"fault", "alarm"}));
  EXPECT_FALSE(json(set_of_bits + ".description").contains("codes"));
  const Json full{R"({"raw":2,"fault":false,"alarm":true})"};
  for (const auto* text : {"alarm", "[\"alarm\"]", "2", R"({"alarm": true})"}) {
    EXPECT_EQ(set(set_of_bits + ".command", text).verdict, Verdict::kApplied) << text;
    EXPECT_EQ(actuated().back().value, Value(full)) << text;
  }
  report("7", join.capabilities[0].point, full);
  EXPECT_EQ(command_state(set_of_bits), "confirmed");
  EXPECT_EQ(text(set_of_bits + ".value"), full.text);
}

TEST_F(CommandsInWords, WordsThatAPeerNamesForANumberChangeNothing) {
  start();
  Join join;
  join.capabilities.push_back(capability(Kind::kActuator, kKnob));
  join.capabilities.back().words = {{0, "off"}};
  say("7", join);
  EXPECT_EQ(set("proxy.hall.7.actuator.knob-1.command", "5").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated().back().value, Value(std::int64_t{5}));
}

}  // namespace
}  // namespace rubicon::proxy
