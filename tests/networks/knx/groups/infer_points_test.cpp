#include <algorithm>

#include "networks/knx/groups/import.h"
#include "networks/knx/groups/infer_points.h"
#include "networks/knx/groups/support.h"
#include "networks/knx/groups/words.h"

namespace rubicon::networks::knx::groups {
namespace {

GroupEntry entry(std::string_view address, std::string name, std::string_view type, std::string middle = "Hall") {
  GroupEntry out;
  out.address = ga(address);
  out.name = std::move(name);
  out.main_group = "House";
  out.middle_group = std::move(middle);
  if (!type.empty()) out.dpt = dpt(type);
  return out;
}

struct Guessed {
  std::vector<GroupPoint> points;
  Report report;
};

Guessed guess(const std::vector<GroupEntry>& entries, bool by_name = true) {
  Guessed out;
  out.points = infer_points(entries, by_name, out.report);
  return out;
}

TEST(KindOfType, CommandsAreActuatorsAndMeasuredValuesSensors) {
  for (const auto* type :
       {"1.001", "1.008", "1.*", "1.100", "2.001", "3.007", "5.001", "5.003", "5.*", "7.600", "17.001", "18.001",
        "20.102", "20.*", "23.001", "213.100", "222.100", "232.600", "251.600"}) {
    EXPECT_EQ(kind_of_type(dpt(type)), Kind::kActuator) << type;
  }
  for (const auto* type : {"1.005",  "1.011",  "1.018",  "1.019",  "4.001",  "5.010",  "6.010",  "7.001",  "8.001",
                           "9.001",  "9.*",    "10.001", "11.001", "12.001", "13.013", "14.056", "16.000", "19.001",
                           "20.014", "21.001", "22.101", "26.001", "27.001", "28.001", "29.010", "219.001"}) {
    EXPECT_EQ(kind_of_type(dpt(type)), Kind::kSensor) << type;
  }
  EXPECT_EQ(kind_of_type({}), Kind::kSensor);
}

struct Pair {
  const char *command, *command_type, *state, *state_type;
};

class Pairs : public ::testing::TestWithParam<Pair> {};

TEST_P(Pairs, BecomeOneActuatorAndAreNamedInTheReport) {
  const auto& [command, command_type, state, state_type] = GetParam();
  const auto [points, report] = guess({entry("1/0/2", state, state_type), entry("1/0/1", command, command_type)});
  ASSERT_EQ(points.size(), 1U) << report_text(report);
  EXPECT_EQ(points[0].address, ga("1/0/1"));
  EXPECT_EQ(points[0].state, ga("1/0/2"));
  EXPECT_EQ(points[0].kind, Kind::kActuator);
  EXPECT_EQ(points[0].name, command);
  EXPECT_EQ(report.paired, 1U);
  EXPECT_NE(report_text(report).find(state), std::string::npos) << report_text(report);
}

INSTANTIATE_TEST_SUITE_P(InSixLanguages, Pairs,
                         ::testing::Values(Pair{"Lamp", "1.001", "Lamp status", "1.011"},
                                           Pair{"Lamp on/off", "1.001", "Lamp feedback", "1.001"},
                                           Pair{"Lamp switch", "1.001", "Lamp STATE", "1.001"},
                                           Pair{"Flur Decke schalten", "1.001", "Flur Decke Status", "1.011"},
                                           Pair{"Licht ein/aus", "1.001", "Licht Rückmeldung", "1.001"},
                                           Pair{"Licht schalten", "1.001", "Licht RÜCKMELDUNG", "1.001"},
                                           Pair{"Dimmer Wert", "5.001", "Dimmer Wert RM", "5.001"},
                                           Pair{"Jalousie Sollwert", "5.001", "Jalousie Istwert", "5.001"},
                                           Pair{"Ventil Befehl", "5.001", "Ventil Stellung", "5.001"},
                                           Pair{"Raum Sollwert", "9.001", "Raum Sollwert Status", "9.001"},
                                           Pair{"Lampe commande", "1.001", "Lampe état", "1.001"},
                                           Pair{"Lampe marche/arrêt", "1.001", "Lampe retour d'état", "1.001"},
                                           Pair{"Luce comando", "1.001", "Luce stato", "1.001"},
                                           Pair{"Luz mando", "1.001", "Luz estado", "1.001"},
                                           Pair{"Lamp schakelen", "1.001", "Lamp terugmelding", "1.001"},
                                           Pair{"Setpoint", "9.001", "Setpoint status", "9.001"},
                                           Pair{"Raum Sollwert", "9.001", "Raum aktueller Sollwert", "9.001"},
                                           Pair{"schalten", "1.001", "Status", "1.001"}));

class NoPairs : public ::testing::TestWithParam<Pair> {};

TEST_P(NoPairs, StayTwoPoints) {
  const auto& [command, command_type, state, state_type] = GetParam();
  EXPECT_EQ(guess({entry("1/0/1", command, command_type), entry("1/0/2", state, state_type)}).points.size(), 2U);
}

INSTANTIATE_TEST_SUITE_P(OtherNamesOrTypes, NoPairs,
                         ::testing::Values(Pair{"Lamp 1", "1.001", "Lamp 2 status", "1.011"},
                                           Pair{"Lamp", "1.001", "Lamp status", "5.001"},
                                           Pair{"Lamp", "1.001", "Lamp status", ""},
                                           Pair{"Temperatur Soll", "9.001", "Temperatur Ist", "9.001"},
                                           Pair{"Temperature", "9.001", "Temperature status", "9.001"},
                                           Pair{"Door contact", "1.019", "Door contact status", "1.019"},
                                           Pair{"Lamp", "1.001", "Lamp", "1.001"}));

TEST(InferPoints, OtherGroupsAreNoPairs) {
  const auto found = guess({entry("1/0/1", "Lamp", "1.001", "Hall"), entry("1/0/2", "Lamp status", "1.011", "Cellar")});
  EXPECT_EQ(found.points.size(), 2U);
}

TEST(InferPoints, AmbiguousPairsAreNotMadeAndReported) {
  const auto found = guess({entry("1/0/1", "Lamp", "1.001"), entry("1/0/2", "Lamp status", "1.011"),
                            entry("1/0/3", "Lamp feedback", "1.011")});
  EXPECT_EQ(found.points.size(), 3U);
  EXPECT_EQ(found.report.paired, 0U);
  EXPECT_NE(report_text(found.report).find("not paired: 'Lamp'"), std::string::npos);
}

TEST(InferPoints, OfSeveralCommandsTheOneWithTheSameTypeIsPaired) {
  const auto found = guess(
      {entry("1/0/1", "Blind", "1.008"), entry("1/0/2", "Blind", "1.007"), entry("1/0/3", "Blind status", "1.008")});
  ASSERT_EQ(found.points.size(), 2U);
  EXPECT_EQ(found.points[0].state, ga("1/0/3"));
  EXPECT_FALSE(found.points[1].state);
}

TEST(InferPoints, WordsInANameDecideItsKindAndAreNamed) {
  const auto found =
      guess({entry("1/0/1", "Setpoint comfort", "9.001"), entry("1/0/2", "Valve status", "5.001"),
             entry("1/0/3", "Fensterkontakt", "1.001"), entry("1/0/4", "Temperatur an der Wand", "9.001"),
             entry("1/0/5", "Bewegungsmelder sperren", "1.001"), entry("1/0/6", "Lamp command", "")});
  std::vector<Kind> kinds;
  for (const auto& point : found.points) kinds.push_back(point.kind);
  EXPECT_EQ(kinds, (std::vector{Kind::kActuator, Kind::kSensor, Kind::kSensor, Kind::kSensor, Kind::kActuator,
                                Kind::kSensor}));
  EXPECT_EQ(found.report.kinds_by_name, 3U);
  EXPECT_NE(report_text(found.report)
                .find("'Setpoint comfort' is an actuator by its name (setpoint), by its type it "
                      "would be a sensor"),
            std::string::npos)
      << report_text(found.report);
}

TEST(InferPoints, AktuellInAnyFormIsAReport) {
  for (const auto* name : {"Aktueller Sollwert", "aktuelle Betriebsart", "Sollwert aktuell", "AKTUELLES Niveau"}) {
    const auto found = guess({entry("1/0/1", name, "5.001")});
    EXPECT_EQ(found.points.at(0).kind, Kind::kSensor) << name;
  }
}

GroupEntry used(GroupEntry entry, Use use) {
  entry.use = use;
  return entry;
}

TEST(InferPoints, WhatObjectsDoDecidesBeforeTypesAndNames) {
  const std::vector entries{used(entry("1/0/1", "Lamp status", "1.001"), Use::kCommanded),
                            used(entry("1/0/2", "Lamp switch", "1.001"), Use::kReported),
                            used(entry("1/0/3", "Temperature", "9.001"), Use::kCommanded),
                            used(entry("1/0/4", "Setpoint", "9.001"), Use::kReported),
                            used(entry("1/0/5", "Setpoint", "9.001"), Use::kShared),
                            used(entry("1/0/6", "Bytes", ""), Use::kCommanded)};
  for (const bool by_name : {true, false}) {
    const auto found = guess(entries, by_name);
    std::vector<Kind> kinds;
    for (const auto& point : found.points) kinds.push_back(point.kind);
    EXPECT_EQ(kinds, (std::vector{Kind::kActuator, Kind::kSensor, Kind::kActuator, Kind::kSensor,
                                  by_name ? Kind::kActuator : Kind::kSensor, Kind::kSensor}))
        << report_text(found.report);
    EXPECT_EQ(found.report.kinds_by_project, 2U) << "1/0/2 and 1/0/3 differ from their types";
    EXPECT_EQ(found.report.paired, 0U) << "a command has no state word, a report commands nothing";
  }
}

TEST(InferPoints, StateAddressesOfAProjectArePairedBeforeNames) {
  auto command = used(entry("1/0/1", "Lamp", "1.001"), Use::kCommanded);
  command.state = ga("1/0/3");
  const std::vector entries{command, used(entry("1/0/2", "Lamp status", "1.011"), Use::kShared),
                            used(entry("1/0/3", "Answer", "1.001", "Other"), Use::kReported)};
  const auto found = guess(entries);
  ASSERT_EQ(found.points.size(), 2U);
  EXPECT_EQ(found.points[0].state, ga("1/0/3"));
  EXPECT_EQ(found.points[0].kind, Kind::kActuator);
  EXPECT_EQ(found.points[1].kind, Kind::kSensor);
  EXPECT_EQ(found.report.paired_by_project, 1U);
  EXPECT_NE(report_text(found.report).find("by the project: 'Lamp' reports on 1/0/3 'Answer'"), std::string::npos);
  const auto facts = guess(entries, false);
  ASSERT_EQ(facts.points.size(), 2U) << "what the project states is not inferred from names";
  EXPECT_EQ(facts.points[0].state, ga("1/0/3"));
  EXPECT_EQ(facts.points[0].kind, Kind::kActuator);
}

TEST(InferPoints, AStateAddressOfAProjectMustBeThereAndFit) {
  auto missing = used(entry("1/0/1", "Lamp", "1.001"), Use::kCommanded);
  missing.state = ga("7/0/1");
  auto other_type = used(entry("1/0/2", "Dimmer", "5.001"), Use::kCommanded);
  other_type.state = ga("1/0/3");
  auto itself = used(entry("1/0/4", "Fan", "1.001"), Use::kCommanded);
  itself.state = ga("1/0/4");
  const auto found = guess({missing, other_type, used(entry("1/0/3", "Answer", "1.001"), Use::kReported), itself});
  EXPECT_EQ(found.points.size(), 4U);
  EXPECT_EQ(found.report.paired_by_project, 0U);
}

TEST(InferPoints, FunctionAndRoomDescribeAPoint) {
  auto lamp = entry("1/0/1", "Lamp", "1.001"), fan = entry("1/0/2", "Fan", "1.001");
  lamp.function = fan.function = "Table lamp";
  lamp.room = "First floor / Kitchen";
  fan.description = "of the oven";
  const auto found = guess({lamp, fan});
  EXPECT_EQ(found.points[0].description, "Table lamp");
  EXPECT_EQ(found.points[0].room, "First floor / Kitchen");
  EXPECT_EQ(found.points[1].description, "of the oven");
}

TEST(InferPoints, WithoutInferenceEachAddressIsAPointByItsType) {
  const auto found = guess(
      {entry("1/0/2", "Lamp status", "1.001"), entry("1/0/1", "Lamp", "1.001"), entry("1/0/3", "Setpoint", "9.001")},
      false);
  ASSERT_EQ(found.points.size(), 3U);
  EXPECT_EQ(found.points[0].address, ga("1/0/1"));
  EXPECT_EQ(found.points[1].kind, Kind::kActuator);
  EXPECT_EQ(found.points[2].kind, Kind::kSensor);
  EXPECT_TRUE(found.report.findings.empty());
}

TEST(InferPoints, ListeningAddressesOfTheSameMainTypeAreUsed) {
  auto lamp = entry("1/0/1", "Lamp", "1.001");
  lamp.listen = {ga("0/0/1"), ga("0/0/2"), ga("0/0/3"), ga("1/0/1")};
  const auto found = guess({lamp, entry("0/0/1", "All off", "1.001"), entry("0/0/2", "Scene", "18.001")});
  ASSERT_EQ(found.points.size(), 3U);
  EXPECT_EQ(found.points[2].listen, (std::vector{ga("0/0/1")}));
}

TEST(InferPoints, APointIsADeviceOfItsOwnWithTheFilesNames) {
  auto lamp = entry("1/4/6", "Lamp", "5.001");
  lamp.description = "over the table";
  const auto point = guess({lamp}).points.at(0);
  EXPECT_EQ(point.device, "");
  EXPECT_EQ(wire::to_key_part(point.address), "1_4_6");
  EXPECT_EQ(point.instance, "1");
  EXPECT_EQ(point.description, "over the table");
  EXPECT_EQ(point.main_group, "House");
  EXPECT_EQ(point.middle_group, "Hall");
}

TEST(InferPoints, TheWordTableOfTheDocumentationIsTheOneUsed) {
  std::ifstream file(RUBICON_SOURCE_DIR "/docs/knx-import.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const auto& [word, sense] : kWordTable) {
    EXPECT_NE(page.find("`" + std::string(word) + "`"), page.npos) << word << " is not in docs/knx-import.md";
  }
}

TEST(Import, TheFlatHasThreePairs) {
  if (!shared_file("flat-3-1.csv")) GTEST_SKIP() << "no ../shared/data/knx/import beside the source tree";
  const auto imported = import_file(shared_folder() + "flat-3-1.csv");
  ASSERT_TRUE(imported);
  std::map<std::string, std::string> states;
  for (const auto& point : imported->points) {
    if (point.state) states[to_string(point.address)] = to_string(*point.state);
  }
  EXPECT_EQ(states, (std::map<std::string, std::string>{{"1/0/1", "1/0/2"}, {"1/1/3", "1/1/4"}, {"2/1/3", "2/1/5"}}));
  EXPECT_EQ(imported->points.size(), 31U);
  EXPECT_EQ(imported->report.taken, 34U);
}

TEST(EsfPoints, AListeningAddressThatIsLeftOutIsNamed) {
  auto list = read_group_list(
      "House\r\nA.B.1/0/1\tLamp\tEIS 1 'Switching' (1 Bit)\tLow\t1/0/2 1/0/3 1/0/9\r\n"
      "A.B.1/0/2\tAll\tEIS 1 'Switching' (1 Bit)\tLow\t\r\nA.B.1/0/3\tDim\tEIS 2 'Dimming' (4 Bit)\tLow\t\r\n");
  const auto points = infer_points(list.entries, true, list.report);
  EXPECT_EQ(points.at(0).listen, std::vector<wire::GroupAddress>{ga("1/0/2")});
  const auto warnings = findings(list.report, Finding::Level::kWarning);
  ASSERT_EQ(warnings.size(), 2U) << texts(list.report);
  EXPECT_EQ(warnings[0].text, "listening address 1/0/3 left out: it has another main type");
  EXPECT_EQ(warnings[1].text, "listening address 1/0/9 left out: it is not in the file");
  EXPECT_EQ(warnings[1].line, 2U);
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
