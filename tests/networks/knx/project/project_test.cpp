#include "networks/knx/project/project.h"

#include <fmt/format.h>

#include <algorithm>

#include "networks/knx/groups/group_file.h"
#include "networks/knx/project/support.h"

namespace rubicon::networks::knx::project {
namespace {

using groups::dpt;
using groups::Finding;
using groups::ga;
using groups::GroupEntry;
using groups::Use;
using support::KnxHouse;
using support::small_house;
using support::ZipEntry;
using ::testing::HasSubstr;

/// A way to write the small house: its schema, and a password or none.
struct Form {
  unsigned schema;
  const char* password;
};

class Forms : public ::testing::TestWithParam<Form> {
 protected:
  Project read() {
    auto house = small_house(GetParam().schema);
    house.password = GetParam().password;
    auto project = read_bytes(house.file(), house.password);
    EXPECT_TRUE(project) << project.error().text;
    return project.value_or(Project{});
  }
};

const GroupEntry& at(const Project& project, std::string_view address) {
  static const GroupEntry kNone;
  const auto& entries = project.list.entries;
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.address == ga(address); });
  EXPECT_NE(found, entries.end()) << address;
  return found == entries.end() ? kNone : *found;
}

TEST_P(Forms, GiveTheSameAddresses) {
  const auto project = read();
  EXPECT_EQ(project.id, "P-00F1");
  EXPECT_EQ(project.name, "House");
  EXPECT_EQ(project.schema, GetParam().schema);
  EXPECT_EQ(project.was_protected, *GetParam().password != '\0');
  ASSERT_EQ(project.list.entries.size(), 9U) << report_text(project.list.report);
  const auto& lamp = at(project, "1/0/1");
  EXPECT_EQ(lamp.name, "Kitchen lamp");
  EXPECT_EQ(lamp.main_group, "Main 1");
  EXPECT_EQ(lamp.middle_group, "Middle 0");
  EXPECT_EQ(lamp.dpt, dpt("1.001")) << "of its objects";
  EXPECT_EQ(at(project, "1/0/3").description, "over the \"table\"\nbrightness");
  EXPECT_TRUE(at(project, "1/1/1").central);
  EXPECT_TRUE(at(project, "2/0/2").secured);
  EXPECT_EQ(at(project, "2/0/2").security, "On");
  EXPECT_EQ(project.list.report.secured, 1U);
  EXPECT_EQ(project.list.report.warnings + project.list.report.errors, 0U) << report_text(project.list.report);
}

TEST_P(Forms, GiveTheUseOfEachAddress) {
  const auto project = read();
  EXPECT_EQ(at(project, "1/0/1").use, Use::kCommanded);
  EXPECT_EQ(at(project, "1/0/1").state, ga("1/0/2"));
  EXPECT_EQ(at(project, "1/0/2").use, Use::kReported);
  EXPECT_EQ(at(project, "1/0/3").state, ga("1/0/4")) << "by its function";
  EXPECT_EQ(at(project, "1/1/1").use, Use::kCommanded);
  EXPECT_EQ(at(project, "2/0/1").use, Use::kReported);
  EXPECT_EQ(at(project, "2/0/2").state, ga("2/0/3")) << "by objects in a module";
  EXPECT_EQ(at(project, "2/0/4").use, Use::kUnknown);
}

TEST_P(Forms, GiveRoomsAndFunctions) {
  const auto project = read();
  EXPECT_EQ(at(project, "1/0/3").function, "Table lamp");
  EXPECT_EQ(at(project, "1/0/3").room, "Ground floor / Kitchen");
  EXPECT_EQ(at(project, "1/0/1").room, "Ground floor / Kitchen") << "of the button; the actuator is in a board";
  EXPECT_EQ(at(project, "1/1/1").room, "") << "only the actuator in the board uses it";
  EXPECT_EQ(at(project, "2/0/1").room, "Roof / Mast");
}

TEST_P(Forms, GiveDevicesWithTheTextsOfTheirObjects) {
  const auto project = read();
  ASSERT_EQ(project.installations.size(), 1U);
  const auto& devices = project.installations[0].devices;
  ASSERT_EQ(devices.size(), 4U) << "the power supply has no address";
  EXPECT_EQ(to_string(devices[0].address.value()), "1.1.5");
  EXPECT_EQ(devices[1].objects[0].traits.text, "Rocker left") << "a parameter of the device";
  EXPECT_EQ(devices[3].objects[0].traits.text, "RTC 3 (bath)") << "an argument of the module and a parameter";
}

std::string name_of(const testing::TestParamInfo<Form>& form) {
  return fmt::format("Schema{}{}", form.param.schema, *form.param.password == '\0' ? "" : "Protected");
}

INSTANTIATE_TEST_SUITE_P(All, Forms,
                         ::testing::Values(Form{11, ""}, Form{14, ""}, Form{20, ""}, Form{21, ""}, Form{22, ""},
                                           Form{23, ""}, Form{11, "h\u00e4user"}, Form{20, "h\u00e4user"},
                                           Form{21, "h\u00e4user \u20ac"}, Form{23, "flatpass"}),
                         name_of);

TEST(KnxProject, StylesAreNotations) {
  for (const auto& [style, shown] : std::vector<std::pair<std::string, std::string>>{
           {"ThreeLevel", "1/0/1"}, {"TwoLevel", "1/1"}, {"Free", "2049"}}) {
    auto house = small_house(20);
    house.style = style;
    const auto project = read_bytes(house.file()).value();
    EXPECT_EQ(to_string(project.list.entries[0].address, project.list.entries[0].notation), shown);
    EXPECT_EQ(project.list.entries[0].middle_group, style == "ThreeLevel" ? "Middle 0" : "");
  }
}

TEST(KnxProject, InstancesGoBeforeTheirProgram) {
  auto house = small_house(20);
  house.devices[0].objects[0].instance = "WriteFlag=\"Disabled\" TransmitFlag=\"Enabled\" DatapointType=\"DPST-1-2\"";
  house.devices[1].objects[0].groups.clear();
  const auto project = read_bytes(house.file()).value();
  EXPECT_EQ(at(project, "1/0/1").use, Use::kReported);
  EXPECT_EQ(at(project, "1/0/1").dpt, dpt("1.002"));
}

TEST(KnxProject, PointsHaveKindStateRoomAndDescription) {
  const auto file = small_house(23).file();
  const auto imported = import_project(file_with(file), "house.knxproj", {}, {});
  ASSERT_TRUE(imported) << imported.error().text;
  const auto& points = imported->points;
  ASSERT_EQ(points.size(), 6U) << report_text(imported->report);
  EXPECT_EQ(points[0].state, ga("1/0/2"));
  EXPECT_EQ(points[1].state, ga("1/0/4"));
  EXPECT_EQ(points[1].room, "Ground floor / Kitchen");
  EXPECT_EQ(points[4].kind, Kind::kActuator) << "a setpoint of type 9.001, by its objects";
  EXPECT_EQ(points[4].state, ga("2/0/3"));
  EXPECT_EQ(imported->report.paired_by_project, 3U);
  EXPECT_EQ(imported->report.paired, 0U);
  EXPECT_EQ(imported->secured, std::vector{ga("2/0/2")});
  const auto yaml = to_yaml(points, "house.knxproj");
  EXPECT_THAT(yaml, HasSubstr("room: Ground floor / Kitchen"));
  EXPECT_THAT(report_text(imported->report),
              HasSubstr("house.knxproj, project of ETS 6 (schema 23): 9 group addresses"));
}

TEST(KnxProject, ImportedAgainItKeepsIdsAndUpdatesTheRest) {
  const auto first = import_project(file_with(small_house(20).file()), "house.knxproj", {}, {}).value();
  auto known = first.points;
  known[0].instance = "ceiling";
  known[0].device = "kitchen";
  auto house = small_house(23);
  house.groups[0].name = "Ceiling lamp";
  house.groups.push_back({0x0a01, "New", "DPST-1-1"});
  house.devices[1].room = "Ground floor/Bar";
  const auto again = import_project(file_with(house.file()), "house.knxproj", {}, {true, known}).value();
  ASSERT_EQ(again.points.size(), known.size() + 1);
  EXPECT_EQ(again.points[0].name, "Ceiling lamp");
  EXPECT_EQ(again.points[0].instance, "ceiling");
  EXPECT_EQ(again.points[0].device, "kitchen");
  EXPECT_EQ(again.points[0].room, "Ground floor / Bar");
  EXPECT_EQ(again.report.added, 1U);
  EXPECT_EQ(again.report.renamed, 1U);
}

TEST(KnxProject, NothingSecretIsKept) {
  auto house = small_house(23);
  house.password = "flatpass";
  const auto imported = import_project(file_with(house.file()), "house.knxproj", {}, {});
  ASSERT_FALSE(imported);
  const auto secret = secure::Secret::of_text(house.password);
  const auto good = import_project(file_with(house.file()), "house.knxproj", {&secret}, {}).value();
  const auto all = to_yaml(good.points, "x") + report_text(good.report);
  for (const auto* word : {"flatpass", "AAAAAAAA", "in the clear"}) EXPECT_EQ(all.find(word), all.npos) << word;
}

TEST(KnxProject, ANewerSchemaIsReadWithAWarning) {
  const auto project = read_bytes(small_house(24).file()).value();
  EXPECT_EQ(project.list.entries.size(), 9U);
  EXPECT_EQ(project.list.report.warnings, 1U);
  EXPECT_THAT(report_text(project.list.report), HasSubstr("schema 24 is newer than 23"));
}

std::vector<ZipEntry> changed(std::vector<ZipEntry> entries, const std::string& name, const std::string& from,
                              const std::string& to) {
  for (auto& entry : entries) {
    const auto found = entry.content.find(from);
    if (entry.name == name && found != std::string::npos) entry.content.replace(found, from.size(), to);
  }
  return entries;
}

TEST(KnxProject, UnknownSchemasAreRefusedWithWhatWasExpected) {
  const auto entries = small_house(20).entries();
  for (const auto* name_space :
       {"http://knx.org/xml/project/10", "http://knx.org/xml/project/", "urn:x", "http://knx.org/xml/project/twenty"}) {
    const auto error =
        error_of(support::zip_of(changed(entries, "knx_master.xml", "http://knx.org/xml/project/20", name_space)));
    EXPECT_EQ(error.code, ErrorCode::kInvalid);
    EXPECT_THAT(error.text, HasSubstr(fmt::format("house.knxproj: knx_master.xml has the schema '{}', expected "
                                                  "http://knx.org/xml/project/11 to 23 (ETS 4 to 6)",
                                                  name_space)));
  }
}

TEST(KnxProject, APasswordThatIsMissingOrWrongIsRefused) {
  for (const unsigned schema : {20U, 23U}) {
    auto house = small_house(schema);
    house.password = "right";
    const auto file = house.file();
    const auto missing = error_of(file);
    EXPECT_EQ(missing.code, ErrorCode::kRefused);
    EXPECT_EQ(missing.text, "house.knxproj: the project P-00F1 is protected by a password, and none was given");
    const auto wrong = error_of(file, "wrong");
    EXPECT_EQ(wrong.code, ErrorCode::kRefused);
    EXPECT_THAT(wrong.text, HasSubstr("house.knxproj: the password of the project P-00F1 is wrong"));
  }
}

TEST(KnxProject, EveryWrongPasswordOfZipCryptoIsRefused) {
  auto house = small_house(20);  // one in 256 passes the check of ZipCrypto itself
  house.password = "right";
  const auto file = house.file();
  for (int i = 0; i < 600; ++i) {
    const auto error = error_of(file, fmt::format("wrong {}", i));
    EXPECT_EQ(error.code, ErrorCode::kRefused) << i << error.text;
    EXPECT_EQ(error.text.find(fmt::format("wrong {}", i)), std::string::npos) << "the password is not shown";
  }
}

TEST(KnxProject, APasswordForAnOpenProjectIsNotNeeded) {
  EXPECT_TRUE(read_bytes(small_house(23).file(), "any"));
}

TEST(KnxProject, CutAnywhereItIsRefused) {
  for (const auto* password : {"", "flatpass"}) {
    auto house = small_house(20);
    house.password = password;
    const auto file = house.file();
    for (std::size_t percent = 0; percent < 100; ++percent) {
      const auto error = error_of(file.substr(0, file.size() * percent / 100), password);
      EXPECT_EQ(error.code, ErrorCode::kInvalid) << percent << error.text;
      EXPECT_THAT(error.text, HasSubstr("house.knxproj: ")) << percent;
    }
  }
}

TEST(KnxProject, ADamagedByteNeverPassesUnseenInTheAddresses) {
  const auto house = small_house(20);
  const auto file = house.file();
  const auto whole = read_bytes(file).value();
  const auto name = file.find("P-00F1/0.xml");
  ASSERT_NE(name, file.npos);
  for (std::size_t at = name + 12; at < name + 400; at += 3) {
    auto damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const auto project = read_bytes(damaged);
    EXPECT_TRUE(!project || project->list.entries == whole.list.entries) << at;
  }
}

TEST(KnxProject, WhatIsMissingIsNamed) {
  auto entries = small_house(20).entries();
  const auto without = [&](const std::string& name) {
    auto rest = entries;
    std::erase_if(rest, [&](const ZipEntry& entry) { return entry.name.starts_with(name); });
    return error_of(support::zip_of(rest)).text;
  };
  EXPECT_THAT(without("knx_master"), HasSubstr("has no entry knx_master.xml, expected a project of ETS"));
  EXPECT_THAT(without("P-"), HasSubstr("has no project"));
  EXPECT_THAT(without("P-00F1/0"), HasSubstr("the project P-00F1 has no entry 0.xml"));
  EXPECT_THAT(without("P-00F1/project"), HasSubstr("the project P-00F1 has no entry project.xml"));
  EXPECT_THAT(error_of("PK\x05\x06" + std::string(18, '\0')).text, HasSubstr("has no entry knx_master.xml"));
  entries.push_back({"P-00F2/0.xml", "x"});
  EXPECT_THAT(error_of(support::zip_of(entries)).text, HasSubstr("has the projects P-00F1 and P-00F2, expected one"));
}

TEST(KnxProject, EntitiesAreNeverExpanded) {
  auto house = small_house(20);
  for (const auto* name : {"P-00F1/0.xml", "P-00F1/project.xml", "knx_master.xml"}) {
    auto entries = house.entries();
    for (auto& entry : entries) {
      if (entry.name == name)
        entry.content = "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;\">]><KNX a=\"&b;\"/>";
    }
    const auto error = error_of(support::zip_of(entries));
    EXPECT_THAT(error.text, HasSubstr(fmt::format("{}:1: DOCTYPE not allowed", name)));
    EXPECT_EQ(error.code, ErrorCode::kInvalid) << "kRefused is for passwords";
  }
}

TEST(KnxProject, WrongXmlIsNamedWithEntryAndLine) {
  const auto entries = changed(small_house(20).entries(), "P-00F1/0.xml", "<GroupAddresses>", "\n\n</Wrong>");
  EXPECT_THAT(error_of(support::zip_of(entries)).text, HasSubstr("house.knxproj: P-00F1/0.xml:4: not well-formed"));
}

TEST(KnxProject, AnEmptyProjectHasNoAddressAndAWarning) {
  KnxHouse house;
  const auto project = read_bytes(house.file()).value();
  EXPECT_TRUE(project.list.entries.empty());
  EXPECT_THAT(report_text(project.list.report), HasSubstr("the project has no group address"));
}

TEST(KnxProject, WrongAddressesCostOnlyThemselves) {
  auto house = small_house(20);
  house.groups[1].address = 0;
  house.groups[4].address = 0x0801;
  const auto entries = changed(house.entries(), "P-00F1/0.xml", "Address=\"2051\"", "Address=\"70000\"");
  const auto project = read_bytes(support::zip_of(entries)).value();
  EXPECT_EQ(project.list.entries.size(), 6U);
  const auto text = report_text(project.list.report);
  EXPECT_THAT(text, HasSubstr("its address is '0', expected a number from 1 to 65535"));
  EXPECT_THAT(text, HasSubstr("its address is '70000'"));
  EXPECT_THAT(text, HasSubstr("duplicate address"));
}

TEST(KnxProject, ProgramsThatCannotBeReadCostWhatOnlyTheyKnow) {
  const auto good = small_house(20).entries();
  const std::string program = "M-00FA/M-00FA_A-0001-01-0001.xml";
  auto gone = good, broken = good, no_hardware = good;
  std::erase_if(gone, [&](const ZipEntry& entry) { return entry.name == program; });
  for (auto& entry : broken) {
    if (entry.name == program) entry.content = "<KNX><broken";
  }
  std::erase_if(no_hardware, [](const ZipEntry& entry) { return entry.name == "M-00FA/Hardware.xml"; });
  for (const auto& entries : {gone, broken, no_hardware}) {
    const auto project = read_bytes(support::zip_of(entries));
    ASSERT_TRUE(project) << project.error().text;
    EXPECT_EQ(project->list.entries.size(), 9U);
    EXPECT_GE(project->list.report.warnings, 1U);
    EXPECT_EQ(at(*project, "1/0/3").dpt, dpt("5.001"));
  }
  EXPECT_THAT(report_text(read_bytes(support::zip_of(gone))->list.report),
              HasSubstr("application program of 1.1.5 (M-00FA_A-0001-01-0001): has no entry"));
}

TEST(KnxProject, IsRecognisedByItsFirstBytesOrItsName) {
  const auto zip = file_with(small_house(20).file()), csv = file_with("Group name;Address\n");
  EXPECT_TRUE(is_project(*zip, "any.bin").value());
  EXPECT_TRUE(is_project(*csv, "House.KNXPROJ").value());
  EXPECT_FALSE(is_project(*csv, "house.csv").value());
  Bytes first(2);
  ASSERT_TRUE(zip->read(first));
  EXPECT_EQ(base::as_text(first), "PK") << "the file is at its beginning again";
}

TEST(KnxProject, ALargeOneIsReadWhole) {
  const auto project = read_bytes(support::large_house(23, 2000).file()).value();
  EXPECT_EQ(project.list.entries.size(), 2000U);
  EXPECT_EQ(project.list.report.untyped, 0U) << report_text(project.list.report);
  EXPECT_EQ(project.list.report.warnings, 0U);
}

}  // namespace
}  // namespace rubicon::networks::knx::project
