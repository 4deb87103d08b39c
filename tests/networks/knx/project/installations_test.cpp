#include <fmt/format.h>

#include "networks/knx/project/support.h"

namespace rubicon::networks::knx::project {
namespace {

using groups::dpt;
using groups::ga;
using groups::Use;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::string_view kProgram = "M-00FA_A-1";

std::string document_of(const std::string& body) {
  return "<KNX xmlns=\"http://knx.org/xml/project/23\">" + body + "</KNX>";
}

/// A project of these installations. Each device with `M-00FA_H-1_HP-1` has the program.
std::string file_of_installations(const std::string& installations, const std::string& program = "") {
  std::vector<support::ZipEntry> entries{
      {"knx_master.xml", document_of("")},
      {"P-00F1/project.xml",
       document_of("<Project><ProjectInformation Name=\"House\" GroupAddressStyle=\"ThreeLevel\"/></Project>")},
      {"P-00F1/0.xml", document_of("<Project><Installations>" + installations + "</Installations></Project>")},
      {"M-00FA/Hardware.xml", document_of(fmt::format("<Hardware2Program Id=\"M-00FA_H-1_HP-1\">"
                                                      "<ApplicationProgramRef RefId=\"{}\"/></Hardware2Program>",
                                                      kProgram))}};
  if (!program.empty()) entries.push_back({fmt::format("M-00FA/{}.xml", kProgram), document_of(program)});
  return support::zip_of(entries);
}

std::string device_of(const std::string& number, const std::string& content,
                      const std::string& hardware = "M-00FA_H-1_HP-1") {
  return fmt::format(
      "<DeviceInstance Id=\"P-00F1-0_DI-{0}\" Address=\"{0}\" Hardware2ProgramRefId=\"{1}\">{2}</DeviceInstance>",
      number, hardware, content);
}

std::string topology_of(const std::string& devices) {
  return "<Topology><Area Address=\"1\"><Line Address=\"1\">" + devices + "</Line></Area></Topology>";
}

/// `1/0/1` and so on, with the ids GA-1 and so on.
std::string addresses_of(const std::vector<std::string>& names, const std::string& more = "") {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i)
    out += fmt::format("<GroupAddress Id=\"P-00F1-0_GA-{}\" Address=\"{}\" Name=\"{}\" {}/>", i + 1, 2049 + i, names[i],
                       more);
  return "<GroupAddresses><GroupRanges><GroupRange Name=\"Main\">" + out +
         "</GroupRange></GroupRanges></GroupAddresses>";
}

std::string installation_of(const std::string& body, const std::string& name = "") {
  return fmt::format("<Installation Name=\"{}\">{}</Installation>", name, body);
}

/// ETS 6: the id of what is in a module of a module repeats the definition after the instance.
TEST(ProjectInstallations, ModulesInModulesHaveTypeFlagsAndText) {
  const auto program = fmt::format(
      "<ComObject Id=\"{0}_MD-4_SM-1_O-3-1\" Text=\"Room {{{{0:none}}}}\" FunctionText=\"Value\" "
      "DatapointType=\"DPST-9-1\" "
      "ObjectSize=\"2 Bytes\" CommunicationFlag=\"Enabled\" ReadFlag=\"Enabled\" WriteFlag=\"Disabled\" "
      "TransmitFlag=\"Enabled\" TextParameterRefId=\"{0}_MD-4_SM-1_P-15_R-17\"/>"
      "<ComObjectRef Id=\"{0}_MD-4_SM-1_O-3-1_R-2\" RefId=\"{0}_MD-4_SM-1_O-3-1\"/>",
      kProgram);
  const std::string instance = "MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_";
  const auto device =
      device_of("7", fmt::format("<ParameterInstanceRef RefId=\"{0}_{1}P-15_R-17\" Value=\"bath\"/>"
                                 "<ComObjectInstanceRef RefId=\"{1}O-3-1_R-2\" ChannelId=\"{1}CH-4\" Links=\"GA-1\"/>",
                                 kProgram, instance));
  const auto file = file_of_installations(installation_of(topology_of(device) + addresses_of({"bath"})), program);
  const auto project = read_bytes(file).value();
  EXPECT_EQ(project.list.entries.at(0).dpt, dpt("9.001")) << report_text(project.list.report);
  EXPECT_EQ(project.list.entries[0].use, Use::kReported);
  const auto& object = project.installations.at(0).devices.at(0).objects.at(0);
  EXPECT_EQ(object.id, "M-00FA_A-1_MD-4_SM-1_O-3-1_R-2");
  EXPECT_EQ(object.module, "MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2");
  EXPECT_EQ(object.traits.text, "Room bath");
  EXPECT_EQ(project.list.report.warnings, 0U);
}

TEST(ProjectInstallations, ObjectsThatTheirProgramDoesNotHaveAreCounted) {
  const std::string object = "<ComObjectInstanceRef RefId=\"O-{}_R-{}\" Links=\"GA-1\"/>";
  std::string devices;
  for (int i = 1; i <= 7; ++i)
    devices += device_of(std::to_string(i),
                         "<ComObjectInstanceRef RefId=\"O-1_R-1\" Links=\"GA-1\"/>"
                         "<ComObjectInstanceRef RefId=\"O-9_R-9\" Links=\"GA-1\"/>");
  const auto program = fmt::format("<ComObject Id=\"{}_O-1\" DatapointType=\"DPST-1-1\"/>", kProgram);
  const auto project =
      read_bytes(file_of_installations(installation_of(topology_of(devices) + addresses_of({"lamp"})), program))
          .value();
  EXPECT_EQ(project.list.report.warnings, 1U);
  EXPECT_THAT(report_text(project.list.report),
              HasSubstr("house.knxproj: warning: 7 communication objects of 1.1.1, 1.1.2, 1.1.3, 1.1.4, 1.1.5 and 2 "
                        "more devices are not in their application program (M-00FA_A-1)"));
}

TEST(ProjectInstallations, AProgramThatHardwareDoesNotNameIsNamedByItsHardware) {
  std::string devices;
  const std::string object = "<ComObjectInstanceRef RefId=\"O-1_R-1\" DatapointType=\"DPST-1-1\" Links=\"GA-1\"/>";
  for (const auto* number : {"1", "2"}) devices += device_of(number, object, "M-00FA_H-9_HP-9");
  const auto project =
      read_bytes(file_of_installations(installation_of(topology_of(devices) + addresses_of({"lamp"})))).value();
  EXPECT_EQ(project.list.report.warnings, 1U);
  EXPECT_THAT(report_text(project.list.report),
              HasSubstr("application program of 1.1.1, 1.1.2 (M-00FA_H-9_HP-9): not named in Hardware.xml; types and "
                        "flags of 2 communication objects may be missing"));
}

/// The flags of the weather station are not known: that a display takes the value does not make it a command.
TEST(ProjectInstallations, UnknownFlagsAreNotFlagsThatAreOff) {
  const std::string display = "<ComObjectInstanceRef RefId=\"O-1_R-1\" Links=\"GA-1\"/>";
  const auto program = fmt::format(
      "<ComObject Id=\"{0}_O-1\" DatapointType=\"DPST-9-1\" CommunicationFlag=\"Enabled\" ReadFlag=\"Disabled\" "
      "WriteFlag=\"Enabled\" TransmitFlag=\"Disabled\"/>",
      kProgram);
  const auto devices = device_of("1", display, "M-00FA_H-2_HP-2") + device_of("2", display);
  const auto body = topology_of(devices) + addresses_of({"Outside temperature measured"}, "DatapointType=\"DPST-9-1\"");
  auto project = read_bytes(file_of_installations(installation_of(body), program)).value();
  EXPECT_EQ(project.list.entries.at(0).use, Use::kUnknown);
  const auto imported = groups::import_list(std::move(project.list));
  EXPECT_EQ(imported.points.at(0).kind, Kind::kSensor);
}

TEST(ProjectInstallations, ADeviceWithoutAnAddressCountsWithItsLinks) {
  const auto object = std::string("<ComObjectInstanceRef RefId=\"O-1_R-1\" DatapointType=\"DPST-1-1\" ") +
                      "CommunicationFlag=\"Enabled\" WriteFlag=\"Enabled\" Links=\"GA-1\"/>";
  const auto body = topology_of(device_of("", object) + device_of("", "")) + addresses_of({"planned lamp"});
  const auto project = read_bytes(file_of_installations(installation_of(body))).value();
  EXPECT_EQ(project.list.entries.at(0).dpt, dpt("1.001"));
  EXPECT_EQ(project.list.entries[0].use, Use::kCommanded);
  EXPECT_EQ(project.installations.at(0).devices.size(), 1U) << "without links it is a power supply";
  EXPECT_THAT(report_text(project.list.report), HasSubstr("application program of a device without an address"));
}

std::string locations_of(const std::vector<std::pair<std::string, std::string>>& devices_in) {
  std::string out;
  for (const auto& [building, device] : devices_in)
    out += fmt::format(
        "<Space Type=\"Building\" Name=\"{}\"><Space Type=\"Floor\" Name=\"EG\"><Space Type=\"Room\" "
        "Name=\"Kueche\"><DeviceInstanceRef RefId=\"P-00F1-0_DI-{}\"/></Space></Space></Space>",
        building, device);
  return "<Locations>" + out + "</Locations>";
}

TEST(ProjectInstallations, RoomsOfSeveralBuildingsHaveTheirNames) {
  const auto devices = device_of("1", "<ComObjectInstanceRef RefId=\"O-1_R-1\" Links=\"GA-1\"/>") +
                       device_of("2", "<ComObjectInstanceRef RefId=\"O-1_R-1\" Links=\"GA-2\"/>");
  const auto rooms = [&](const std::string& locations) {
    const auto body = topology_of(devices) + locations + addresses_of({"a", "b"});
    const auto project = read_bytes(file_of_installations(installation_of(body))).value();
    return project.list.entries.at(0).room + ", " + project.list.entries.at(1).room;
  };
  EXPECT_EQ(rooms(locations_of({{"Haus A", "1"}, {"Haus B", "2"}})), "Haus A / EG / Kueche, Haus B / EG / Kueche");
  const std::string empty_one = "<Space Type=\"Building\" Name=\"Haus B\"/></Locations>";
  auto one = locations_of({{"Haus A", "1"}});
  one.replace(one.find("</Locations>"), 12, empty_one);
  EXPECT_EQ(rooms(one), "EG / Kueche, ") << "only one has devices";
}

TEST(ProjectInstallations, WithTheSameAddressesBothAreNamed) {
  const auto first = installation_of(addresses_of({"lamp", "blind"}), "House");
  const auto second = installation_of(addresses_of({"pump", "gate", "light"}), "Garden");
  const auto project = read_bytes(file_of_installations(first + second)).value();
  ASSERT_EQ(project.list.entries.size(), 3U);
  EXPECT_EQ(project.list.entries[0].name, "lamp");
  EXPECT_EQ(project.list.entries[2].name, "light") << "only the second has 1/0/3";
  EXPECT_EQ(project.list.report.doubled, 2U);
  EXPECT_EQ(project.list.report.errors, 1U);
  EXPECT_THAT(report_text(project.list.report),
              AllOf(HasSubstr("error: 1/0/1: installation 1 'House' has it, and so has installation 2 'Garden' (2 such "
                              "addresses): the addresses of the second one are left out"),
                    Not(HasSubstr("duplicate address"))));
}

}  // namespace
}  // namespace rubicon::networks::knx::project
