#include <algorithm>

#include "config/yaml.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/groups/support.h"

namespace rubicon::networks::knx::groups {
namespace {

using When = ReadRule::When;

struct Record {
  std::vector<GroupPoint> points;
  std::string errors;
};

Record read(const std::string& yaml) {
  Record out;
  const auto node = config::parse_yaml(yaml, "home.yaml");
  if (!node) {
    out.errors = node.error().text;
    return out;
  }
  ConfigErrors errors;
  ConfigReader reader(*node, "", errors);
  read_groups(reader, out.points);
  reader.finish();
  out.errors = errors.text();
  return out;
}

GroupPoint point(std::string_view address, std::string_view type, Kind kind, std::string name = "") {
  GroupPoint out;
  out.address = ga(address);
  if (!type.empty()) out.dpt = dpt(type);
  out.kind = kind;
  out.name = std::move(name);
  return out;
}

TEST(ReadGroups, EveryKeyOfAPointIsRead) {
  const auto [points, errors] = read(
      "group-names: {1: Lighting, 1/4: Hall}\n"
      "groups:\n"
      "  1/0/1: {dpt: 1.001, kind: actuator, state: 1/0/2, name: Flur Decke schalten}\n"
      "  1/0/7: 9.001\n"
      "  1/4/6: {dpt: 5.001, device: hall, device-name: Hall, instance: ceiling, listen: [1/4/9], read: init,\n"
      "          description: over the door}\n"
      "  2/519:\n"
      "  1/4/8: {dpt: '9.*', kind: actuator, main: Other, middle: '', read: every 5min}\n");
  EXPECT_EQ(errors, "");
  ASSERT_EQ(points.size(), 5U);
  EXPECT_EQ(points[0].state, ga("1/0/2"));
  EXPECT_EQ(points[0].name, "Flur Decke schalten");
  EXPECT_EQ(points[0].main_group, "Lighting");
  EXPECT_EQ(points[1].kind, Kind::kSensor);
  EXPECT_EQ(points[1].dpt, dpt("9.001"));
  EXPECT_EQ(points[2].kind, Kind::kActuator) << "by its type";
  EXPECT_EQ(points[2].device, "hall");
  EXPECT_EQ(points[2].device_name, "Hall");
  EXPECT_EQ(points[2].instance, "ceiling");
  EXPECT_EQ(points[2].listen, (std::vector{ga("1/4/9")}));
  EXPECT_EQ(points[2].read.when, When::kInit);
  EXPECT_EQ(points[2].middle_group, "Hall");
  EXPECT_EQ(points[2].description, "over the door");
  EXPECT_FALSE(points[3].dpt);
  EXPECT_EQ(points[3].address, ga("2/2/7"));
  EXPECT_EQ(points[4].main_group, "Other");
  EXPECT_EQ(points[4].middle_group, "");
  EXPECT_EQ(points[4].read, (ReadRule{When::kEvery, std::chrono::minutes(5)}));
}

TEST(ReadGroups, AnAddressWithAStateIsAnActuatorWhateverItsType) {
  const auto [points, errors] = read("groups: {3/1/2: {dpt: 9.001, state: 3/1/3}}\n");
  EXPECT_EQ(errors, "");
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].kind, Kind::kActuator);
}

struct Mistake {
  const char *yaml, *expected;
};

class Mistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, AreReportedAtTheirPlaceAndTheOtherPointsRemain) {
  const auto [points, errors] = read(std::string("groups:\n  1/0/1: 1.001\n") + GetParam().yaml);
  EXPECT_NE(errors.find(GetParam().expected), std::string::npos) << errors;
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 0) << errors;
  ASSERT_GE(points.size(), 1U);
  EXPECT_EQ(points[0].address, ga("1/0/1"));
}

INSTANTIATE_TEST_SUITE_P(
    All, Mistakes,
    ::testing::Values(
        Mistake{"  1/9/1: 1.001\n",
                "home.yaml:3:3: groups.1/9/1: '1/9/1' is not a group address: its middle group is 9"},
        Mistake{"  0/0/0: 1.001\n", "home.yaml:3:3: groups.0/0/0: 0/0/0 is the broadcast address"},
        Mistake{"  2049: 1.001\n", "home.yaml:3:3: groups.2049: 1/0/1 is already in the list"},
        Mistake{"  1/0/2: cold\n", "home.yaml:3:10: groups.1/0/2: 'cold' is not a data point type"},
        Mistake{"  1/0/2: {dpt: 999.001}\n", "home.yaml:3:16: groups.1/0/2.dpt: '999.001' is not a data point type"},
        Mistake{"  1/0/2: {dpt: 9.999}\n", "groups.1/0/2.dpt: type 9.999 is not known, expected one of main type 9"},
        Mistake{"  1/0/2: {dpt: 1.001, state: 40/0/1}\n", "home.yaml:3:30: groups.1/0/2.state: '40/0/1'"},
        Mistake{"  1/0/2: {dpt: 1.001, state: 1/0/2}\n", "groups.1/0/2.state: is the address of the point"},
        Mistake{"  1/0/2: {kind: sensor, state: 1/0/3}\n", "groups.1/0/2.state: is only for actuators"},
        Mistake{"  1/0/2: {dpt: 1.001, state: 1/0/9}\n  1/0/3: {dpt: 1.001, state: 1/0/9}\n",
                "home.yaml:4:3: groups.1/0/3: 1/0/9 is already the state address of 1/0/2"},
        Mistake{"  1/0/2: {dpt: 9.001, device: hall}\n  1/0/3: {dpt: 9.001, device: hall}\n",
                "home.yaml:4:3: groups.1/0/3: has the same device, kind, type and instance as 1/0/2"},
        Mistake{"  1/0/2: {kind: lamp}\n", "groups.1/0/2.kind: is 'lamp', expected one of: sensor, actuator"},
        Mistake{"  1/0/2: {listen: [1/0/3, x]}\n", "groups.1/0/2.listen: 'x' is not a group address"},
        Mistake{"  1/0/2: {device: 'a.b'}\n", "groups.1/0/2.device: is 'a.b', expected at most 64 letters"},
        Mistake{"  1/0/2: {instance: ''}\n", "groups.1/0/2.instance: is '', expected at most 64 letters"},
        Mistake{"  1/0/2: {read: sometimes}\n", "groups.1/0/2.read: expected demand, init, never, expire 60min"},
        Mistake{"  1/0/2: {read: every 0s}\n", "groups.1/0/2.read: expected demand"},
        Mistake{"  1/0/2: {typ: 9.001}\n", "groups.1/0/2: unknown key 'typ', known: "},
        Mistake{"  1/0/2: [1]\n", "groups.1/0/2: is a list, expected a map"}));

std::vector<GroupPoint> awkward_points() {
  std::vector<GroupPoint> points;
  const std::vector<std::string> names{"Lamp",
                                       "Ceiling \"island\" on/off",
                                       "Bett; Leselampe links",
                                       "first\nsecond",
                                       "on",
                                       "1.0",
                                       "-",
                                       "a: b # c",
                                       "{x}, [y]",
                                       "Küche €",
                                       "back\\slash",
                                       " blank ",
                                       "tab\there",
                                       "'quoted'",
                                       "~",
                                       "null",
                                       "\xc2\x85 \xe2\x80\xa8",
                                       "%x",
                                       "@y",
                                       "!z",
                                       "&a *b",
                                       "\xef\xbb\xbfmark",
                                       "日本語",
                                       "y",
                                       "bell\x07",
                                       "100 %",
                                       "trailing "};
  std::uint16_t number = 300;
  for (const auto& name : names) {
    GroupPoint each;
    each.address = wire::GroupAddress(number++);
    each.name = name;
    each.description = name + name;
    each.device_name = name;
    each.main_group = "Licht & Co";
    each.middle_group = number % 3 == 0 ? "" : number % 3 == 1 ? "Küche" : name;
    each.dpt = number % 2 == 0 ? std::optional(dpt("9.001")) : std::nullopt;
    each.kind = number % 5 == 0 ? Kind::kActuator : Kind::kSensor;
    points.push_back(each);
  }
  points[0].kind = Kind::kActuator;
  points[0].state = ga("20/0/1");
  points[0].listen = {ga("0/0/1"), ga("0/0/2")};
  points[0].device = "hall";
  points[0].instance = "ceiling";
  points[1].read = {When::kExpire, std::chrono::minutes(60)};
  points[2].read = {When::kEvery, std::chrono::milliseconds(1500)};
  points[3].read = {When::kInit, {}};
  points[4].read = {When::kNever, {}};
  points[5].dpt = dpt("1.*");
  return points;
}

TEST(ToYaml, WhatIsWrittenReadsBackTheSame) {
  const auto points = awkward_points();
  const auto yaml = to_yaml(points, "flat\n.csv \xe2\x80\xa8");
  const auto record = read(yaml);
  EXPECT_EQ(record.errors, "") << yaml;
  ASSERT_EQ(record.points.size(), points.size()) << yaml;
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(record.points[i], points[i]) << points[i].name << yaml;
  EXPECT_EQ(to_yaml(record.points, "flat\n.csv \xe2\x80\xa8"), yaml);
}

TEST(ToYaml, IsSortedByAddressWhateverTheOrder) {
  auto points = awkward_points();
  const auto yaml = to_yaml(points, "x");
  std::reverse(points.begin() + 9, points.end());
  EXPECT_EQ(to_yaml(points, "x").substr(0, 40), yaml.substr(0, 40));
  EXPECT_LT(yaml.find("  0/1/44:"), yaml.find("  0/1/45:"));
}

TEST(ToYaml, IsWrittenInTheShortForms) {
  auto lamp = point("1/0/1", "1.001", Kind::kActuator, "Flur Decke schalten");
  lamp.state = ga("1/0/2");
  lamp.main_group = "Lighting";
  lamp.middle_group = "Hall";
  const auto yaml = to_yaml({lamp}, "flat.csv");
  EXPECT_NE(yaml.find("# 1 KNX points from flat.csv."), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("group-names:\n  1: Lighting\n  1/0: Hall\ngroups:\n"
                      "  1/0/1: {dpt: 1.001, kind: actuator, state: 1/0/2, name: Flur Decke schalten}\n"),
            std::string::npos)
      << yaml;
  EXPECT_EQ(read(to_yaml({}, "empty")).errors, "");
}

std::vector<GroupPoint> sample_points() {
  auto lamp = point("1/0/1", "1.001", Kind::kActuator, "Lamp");
  lamp.state = ga("1/0/2");
  lamp.device = "hall";
  lamp.instance = "ceiling";
  auto cold = point("3/1/1", "9.*", Kind::kSensor, "Cold");
  cold.read.when = When::kInit;
  return {lamp, cold, point("4/0/1", "1.019", Kind::kSensor, "Door")};
}

TEST(Merge, TheSameFileAgainChangesNothing) {
  Report report;
  EXPECT_EQ(merge(sample_points(), sample_points(), report), sample_points());
  EXPECT_EQ(report.unchanged, 3U);
  EXPECT_TRUE(report.findings.empty()) << report_text(report);
}

TEST(Merge, ARenamedAddressKeepsItsIdKindTypeAndPair) {
  auto renamed = point("1/0/1", "1.002", Kind::kSensor, "Lampe im Flur");
  renamed.description = "new";
  renamed.middle_group = "Flur";
  Report report;
  const auto merged = merge(sample_points(), {renamed, sample_points()[1], sample_points()[2]}, report);
  auto expected = sample_points();
  expected[0].name = "Lampe im Flur";
  expected[0].description = "new";
  expected[0].middle_group = "Flur";
  EXPECT_EQ(merged, expected);
  EXPECT_EQ(report.renamed, 1U);
  EXPECT_NE(report_text(report).find("'Lamp' is now 'Lampe im Flur': its id is kept"), std::string::npos);
  EXPECT_NE(report_text(report).find("the import has type 1.002, the group file type 1.001"), std::string::npos);
  EXPECT_NE(report_text(report).find("its state address 1/0/2 is no longer in the import: kept"), std::string::npos);
}

TEST(Merge, NewAddressesAreAddedAndVanishedOnesKeptAndNamed) {
  Report report;
  const auto merged =
      merge(sample_points(), {sample_points()[0], point("2/0/1", "1.008", Kind::kActuator, "Blind")}, report);
  ASSERT_EQ(merged.size(), 4U);
  EXPECT_EQ(merged[1].name, "Blind");
  EXPECT_EQ(report.added, 1U);
  EXPECT_EQ(report.vanished, 2U);
  EXPECT_NE(report_text(report).find("3/1/1: 'Cold' is no longer in the import: kept"), std::string::npos);
}

TEST(Merge, AStateAddressNeverBecomesASecondPoint) {
  Report report;
  const auto merged = merge(sample_points(),
                            {point("1/0/1", "1.001", Kind::kActuator, "Lamp"), sample_points()[1], sample_points()[2],
                             point("1/0/2", "1.001", Kind::kSensor, "Lamp status")},
                            report);
  EXPECT_EQ(merged, sample_points());
}

TEST(Merge, APairThatTheGroupFileHasAsTwoPointsStaysTwo) {
  const std::vector<GroupPoint> known{point("1/0/1", "1.001", Kind::kActuator, "Lamp"),
                                      point("1/0/2", "1.001", Kind::kSensor, "Lamp status")};
  auto pair = known[0];
  pair.state = ga("1/0/2");
  Report report;
  EXPECT_EQ(merge(known, {pair}, report), known);
  EXPECT_EQ(report.vanished, 0U) << report_text(report);
  EXPECT_NE(report_text(report).find("the group file is kept"), std::string::npos);
}

TEST(Merge, OtherKindsAndRoomsThatAreGoneAreNotes) {
  auto known = sample_points();
  known[0].room = "Hall";
  known[1].room = "Bath";
  auto imported = known;
  imported[0].kind = known[0].kind == Kind::kActuator ? Kind::kSensor : Kind::kActuator;
  imported[0].room.clear();
  Report report;
  EXPECT_EQ(merge(known, imported, report), known);
  const auto text = report_text(report);
  EXPECT_NE(text.find("the group file " + std::string(known[0].kind == Kind::kActuator ? "an actuator" : "a sensor") +
                      ": the latter is kept"),
            text.npos)
      << text;
  EXPECT_NE(text.find("the import has no room for it: 'Hall' is kept"), text.npos) << text;
  imported[1].room.clear();
  Report list;
  merge(known, imported, list);
  EXPECT_EQ(report_text(list).find("no room"), std::string::npos) << "lists have no rooms at all";
}

TEST(Merge, ANewStateAddressGoesToAnActuatorWithoutOneOrBecomesASensor) {
  const std::vector<GroupPoint> known{point("1/0/1", "1.001", Kind::kActuator, "Lamp"),
                                      point("1/0/5", "1.001", Kind::kSensor, "Button")};
  auto lamp = known[0];
  lamp.state = ga("1/0/2");
  auto button = known[1];
  button.kind = Kind::kActuator;
  button.state = ga("1/0/6");
  Report report;
  const auto merged = merge(known, {lamp, button}, report);
  ASSERT_EQ(merged.size(), 3U);
  EXPECT_EQ(merged[0].state, ga("1/0/2"));
  EXPECT_EQ(merged[1], known[1]);
  EXPECT_EQ(merged[2].address, ga("1/0/6"));
  EXPECT_EQ(merged[2].kind, Kind::kSensor);
}

TEST(Merge, TheNameOfAStateAddressIsThatOfTheImport) {
  auto known = sample_points();
  known[0].state_name = "Lamp status";
  auto renamed = known;
  renamed[0].state_name = "Lamp feedback";
  Report report;
  EXPECT_EQ(merge(known, renamed, report)[0].state_name, "Lamp feedback");
}

TEST(Merge, ANewActuatorDoesNotGetAStateAddressOfTheGroupFile) {
  const std::vector<GroupPoint> known{point("1/0/2", "1.001", Kind::kSensor, "Lamp status")};
  auto lamp = point("1/0/1", "1.001", Kind::kActuator, "Lamp");
  lamp.state = ga("1/0/2");
  Report report;
  const auto merged = merge(known, {lamp}, report);
  ASSERT_EQ(merged.size(), 2U);
  EXPECT_FALSE(merged[0].state);
  EXPECT_EQ(merged[1], known[0]);
}

std::string ten_thousand() {
  std::string text = "Group name;Address;Central;Unfiltered;Description;DatapointType;Security\n";
  for (unsigned i = 0; i < 5000; ++i) {
    const unsigned number = 2048 + i * 2;
    const auto address = [](unsigned each) {
      return std::to_string(each >> 11) + "/" + std::to_string(each >> 8 & 7) + "/" + std::to_string(each & 255);
    };
    const auto name = "Lamp " + std::to_string(i);
    text += name + ";" + address(number) + ";;;;DPST-1-1;Auto\n";
    text += name + " status;" + address(number + 1) + ";;;;DPST-1-11;Auto\n";
  }
  return text;
}

TEST(Import, TenThousandAddressesAreImportedPairedWrittenAndReadBack) {
  const auto imported = import_text(ten_thousand(), "big.csv");
  ASSERT_TRUE(imported);
  EXPECT_EQ(imported->report.taken, 10'000U);
  EXPECT_EQ(imported->report.paired, 5000U);
  EXPECT_EQ(findings(imported->report, Finding::Level::kNote).size(), 5000U) << "each guess is named";
  ASSERT_EQ(imported->points.size(), 5000U);
  const auto record = read(to_yaml(imported->points, "big.csv"));
  EXPECT_EQ(record.errors, "");
  EXPECT_EQ(record.points, imported->points);
}

TEST(GroupFile, PointsOfSeveralSourcesAreCheckedTogether) {
  auto lamp = point("1/0/1", "1.001", Kind::kActuator), other = point("1/0/5", "1.001", Kind::kActuator);
  lamp.state = ga("1/0/2");
  EXPECT_TRUE(conflicts({lamp, other, point("1/0/2", "1.001", Kind::kSensor)}).empty());
  other.state = lamp.state;
  EXPECT_EQ(conflicts({lamp, other}), std::vector<std::string>{"1/0/5: 1/0/2 is already the state address of 1/0/1"});
  EXPECT_EQ(conflicts({lamp, lamp}), std::vector<std::string>{"1/0/1: 1/0/1 is already in the list"});
  auto one = point("1/2/7", "9.001", Kind::kSensor), two = point("1/2/8", "9.001", Kind::kSensor);
  one.device = two.device = "hall";
  const auto same_key = conflicts({one, two});
  ASSERT_EQ(same_key.size(), 1U);
  EXPECT_TRUE(same_key[0].starts_with("1/2/8: has the same device, kind, type and instance as 1/2/7")) << same_key[0];
  two.instance = "2";
  EXPECT_TRUE(conflicts({one, two}).empty());
}

TEST(Import, AGroupFileIsMergedAndTheReportStartsWithCounts) {
  ImportOptions options;
  options.known = sample_points();
  const auto imported =
      import_text("Lamp;1/0/1;;;;DPST-1-1;\nLamp status;1/0/2;;;;DPST-1-1;\nNew;1/0/3;;;;;\n", "flat.csv", options);
  ASSERT_TRUE(imported);
  EXPECT_EQ(imported->points.size(), 4U);
  const auto text = report_text(imported->report);
  EXPECT_TRUE(text.starts_with("flat.csv, ETS CSV 1/1: 3 group addresses imported; 1 without a type, 1 paired"))
      << text;
  EXPECT_NE(text.find("merge: 1 new, 0 renamed, 1 unchanged, 2 no longer in the import (kept)"), std::string::npos)
      << text;
  EXPECT_NE(text.find("flat.csv:3: note: 1/0/3: no type"), std::string::npos) << text;
}

TEST(Import, MissingAndRefusedFilesAreReported) {
  EXPECT_EQ(import_file("/no/such/file.csv").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(import_file("/").error().code, ErrorCode::kIo);
  const auto refused = import_text("Group name;Central\nLamp;\n", "bad.csv");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "bad.csv:1: no address column in the header or below: file refused, nothing imported");
}

TEST(GroupFile, AddressesAreWrittenInTheNotationOfTheProject) {
  GroupPoint point;
  point.address = ga("0/10");
  point.kind = Kind::kActuator;
  point.state = ga("1/519");
  point.state_name = "Status";
  point.listen = {ga("0/11")};
  const auto two = to_yaml({point}, "x", {ga("0/10")}, wire::Notation::kTwoLevel);
  EXPECT_NE(two.find("notation: two-level\n"), std::string::npos) << two;
  EXPECT_NE(two.find("secured-groups: [0/10]\n"), std::string::npos) << two;
  EXPECT_NE(two.find("  0/10: {kind: actuator, state: 1/519, state-name: Status, listen: [0/11]}\n"), std::string::npos)
      << two;
  EXPECT_NE(to_yaml({point}, "x", {}, wire::Notation::kFree).find("  10: {kind: actuator, state: 2567,"),
            std::string::npos);
  EXPECT_EQ(to_yaml({point}, "x").find("notation"), std::string::npos);
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
