#include "island.h"

// Points of types that the catalogue does not know and their devices describe (docs/types.md, "Open types").

namespace rubicon::proxy {
namespace {

using model::DataType;
using model::open_type;

Capability open_point(Kind kind, const std::string& name, DataType data) {
  auto one = capability(kind, open_type(name));
  one.type_name = name;
  one.data = data;
  return one;
}

PointId setting(const std::string& name) {
  return {Kind::kProperty, open_type(name), ""};
}

class OpenTypes : public Island {
 protected:
  Join machine() const {
    Join message;
    auto level = open_point(Kind::kActuator, "brew strength", DataType::kReal);
    level.unit = "g";
    level.minimum = 5;
    level.maximum = 12.5;
    auto mode = open_point(Kind::kActuator, "brew-mode", DataType::kEnumeration);
    mode.words = {{0, "espresso"}, {1, "lungo, large"}};
    auto lid = open_point(Kind::kActuator, "lid", DataType::kBoolean);
    lid.words = {{0, "CLOSED"}, {1, "OPEN"}};
    auto cups = open_point(Kind::kActuator, "cups", DataType::kInteger);
    auto note = open_point(Kind::kProperty, "note", DataType::kText);
    auto plan = open_point(Kind::kProperty, "plan", DataType::kJson);
    note.point.instance = plan.point.instance = "";
    auto knock = open_point(Kind::kSensor, "knock", DataType::kEnumeration);
    knock.words = {{0, "single"}, {1, "double"}};
    knock.report = model::Report::kEvent;
    message.capabilities = {level, mode, lid, cups, note, plan, knock};
    return message;
  }
  void begin() {
    start();
    join("7", machine());
  }
  nlohmann::json description(const std::string& point) const { return json("proxy.hall.7." + point + ".description"); }
  Reply command(const std::string& point, const std::string& value) {
    return set("proxy.hall.7." + point + ".command", value);
  }
  Value actuated() {
    const auto all = hall().sent_bodies<model::Actuate>();
    return all.empty() ? Value() : all.back().value;
  }
};

TEST_F(OpenTypes, ADescriptionSaysAllThatTheDeviceSays) {
  begin();
  const auto level = description("actuator.brew_strength-1");
  EXPECT_EQ(level["type"], "brew_strength");
  EXPECT_EQ(level["type_id"], static_cast<unsigned>(open_type("brew strength")));
  EXPECT_EQ(level["data_type"], "real");
  EXPECT_EQ(level["unit"], "g");
  EXPECT_EQ(level["minimum"], 5);
  EXPECT_EQ(level["maximum"], 12.5);
  EXPECT_EQ(level["report"], "state");
  const auto mode = description("actuator.brew_mode-1");
  EXPECT_EQ(mode["data_type"], "enumeration");
  EXPECT_EQ(mode["words"], (std::vector<std::string>{"espresso", "lungo, large"}));
  EXPECT_EQ(description("actuator.lid-1")["words"], (std::vector<std::string>{"CLOSED", "OPEN"}));
  EXPECT_EQ(description("property.note")["data_type"], "text");
  EXPECT_EQ(description("property.plan")["data_type"], "json");
  EXPECT_EQ(description("sensor.knock-1")["report"], "event");
  EXPECT_EQ(json("proxy.hall.7.description")["capabilities"],
            (std::vector<std::string>{"brew_strength", "brew_mode", "lid", "cups", "note", "plan", "knock"}));
}

TEST_F(OpenTypes, CommandsAreReadByThem) {
  begin();
  EXPECT_EQ(command("actuator.brew_strength-1", "7.5").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated(), Value(7.5));
  EXPECT_EQ(command("actuator.brew_strength-1", "13").text, "brew_strength: '13' is not a number from 5 to 12.5 g");
  EXPECT_EQ(command("actuator.brew_mode-1", "Lungo, large").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated(), Value(std::string("lungo, large")));
  EXPECT_EQ(command("actuator.brew_mode-1", "tea").text,
            "brew_mode: 'tea' is not one of espresso, lungo, large, or a number");
  for (const auto* text : {"OPEN", "on", "1"}) {
    EXPECT_EQ(command("actuator.lid-1", text).verdict, Verdict::kApplied) << text;
    EXPECT_EQ(actuated(), Value(true)) << text;
  }
  EXPECT_EQ(command("actuator.lid-1", "ajar").text, "lid: 'ajar' is not one of CLOSED,OPEN (or off, on)");
  EXPECT_EQ(command("actuator.cups-1", "2").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated(), Value(std::int64_t{2}));
  EXPECT_EQ(command("actuator.cups-1", "2.5").text, "cups: '2.5' is not a whole number");
  EXPECT_EQ(command("property.note", "no sugar").verdict, Verdict::kApplied);
  EXPECT_EQ(command("property.plan", "{\"at\":7}").verdict, Verdict::kApplied);
  EXPECT_EQ(hall().sent_bodies<model::SetProperty>().back().value, Value(Json{"{\"at\":7}"}));
  EXPECT_EQ(command("property.plan", "{at 7}").verdict, Verdict::kRefused);
}

TEST_F(OpenTypes, ReadingsAreCheckedByTheirDataAndShownInTheirWords) {
  begin();
  report("7", actuator(open_type("lid")), true);
  EXPECT_EQ(text("proxy.hall.7.actuator.lid-1.value"), "OPEN");
  report("7", actuator(open_type("lid")), std::string("OPEN"));
  EXPECT_EQ(quality("proxy.hall.7.actuator.lid-1"), "bad");
  report("7", actuator(open_type("brew strength")), 99.0);
  EXPECT_EQ(text("proxy.hall.7.actuator.brew_strength-1.value"), "99") << "bounds limit commands, not readings";
  report("7", actuator(open_type("cups")), 2.5);
  EXPECT_EQ(quality("proxy.hall.7.actuator.cups-1"), "bad");
  report("7", sensor(open_type("knock")), std::string("triple"));
  EXPECT_EQ(text("proxy.hall.7.sensor.knock-1.value"), "triple") << "devices have more words than they declare";
}

TEST_F(OpenTypes, EventsKeepTheirOrderAndDoNotAge) {
  begin();
  report("7", sensor(open_type("knock")), std::string("single"));
  for (int i = 0; i < 10; ++i) {
    time.run_for(50s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(quality("proxy.hall.7.sensor.knock-1"), "good");
  auto chime = machine();
  chime.capabilities = {open_point(Kind::kActuator, "ring", DataType::kInteger)};
  chime.capabilities[0].report = model::Report::kEvent;
  join("8", chime);
  hall().answers = false;
  for (const auto* tune : {"1", "2"}) set("proxy.hall.8.actuator.ring-1.command", tune);
  EXPECT_EQ(hall().sent_bodies<model::Actuate>().size(), 2U);
  EXPECT_EQ(command_state("proxy.hall.8.actuator.ring-1"), "queued") << "neither superseded the other";
}

TEST_F(OpenTypes, ANewDefinitionChangesHowValuesAreRead) {
  begin();
  auto message = machine();
  message.capabilities[3].data = DataType::kReal;
  message.capabilities[2].words = {{0, "shut"}, {1, "ajar"}};
  join("7", message);
  report("7", actuator(open_type("cups")), 2.5);
  EXPECT_EQ(text("proxy.hall.7.actuator.cups-1.value"), "2.5");
  report("7", actuator(open_type("lid")), true);
  EXPECT_EQ(text("proxy.hall.7.actuator.lid-1.value"), "ajar");
}

TEST_F(OpenTypes, ValuesAndDescriptionsOutlastARestart) {
  remember();
  begin();
  report("7", actuator(open_type("lid")), true);
  report("7", actuator(open_type("brew-mode")), std::string("lungo, large"));
  report("7", setting("plan"), Json{"{\"at\":7}"});
  time.run_for(20s);
  restart();
  EXPECT_EQ(text("proxy.hall.7.actuator.lid-1.value"), "OPEN");
  EXPECT_EQ(text("proxy.hall.7.actuator.brew_mode-1.value"), "lungo, large");
  EXPECT_EQ(text("proxy.hall.7.property.plan.value"), "{\"at\":7}");
  EXPECT_EQ(quality("proxy.hall.7.actuator.lid-1"), "stored");
  EXPECT_EQ(description("actuator.brew_strength-1")["maximum"], 12.5);
  EXPECT_EQ(command("actuator.lid-1", "OPEN").verdict, Verdict::kApplied);
}

TEST_F(OpenTypes, TheNameInKeysIsSafeAndDistinct) {
  start();
  const std::string stem(60, 'x');
  Join message;
  for (const auto& name : {stem + "1", stem + "2", std::string("t\xc3\xa9-l\xc3\xa9")})
    message.capabilities.push_back(open_point(Kind::kSensor, name, DataType::kReal));
  join("7", message);
  const auto sensors = json("proxy.hall.7.description")["sensors"];
  ASSERT_EQ(sensors.size(), 3U);
  EXPECT_NE(sensors[0], sensors[1]);
  EXPECT_LE(sensors[0].get<std::string>().size(), 42U);
  EXPECT_EQ(sensors[2], "t___l__-1");
}

TEST_F(OpenTypes, OneCalledRateIsNotTheRateOfTheProxy) {
  start();
  auto rate = open_point(Kind::kProperty, "rate", DataType::kText);
  rate.point.instance = "";
  Join message;
  message.capabilities = {rate};
  join("7", message);
  EXPECT_EQ(command("property.rate", "fast").verdict, Verdict::kApplied);
  EXPECT_EQ(hall().sent_bodies<model::SetProperty>().size(), 1U);
}

}  // namespace
}  // namespace rubicon::proxy
