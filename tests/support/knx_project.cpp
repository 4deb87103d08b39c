#include "support/knx_project.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "networks/knx/secure/passwords.h"
#include "support/xml_text.h"

namespace rubicon::support {

namespace {

std::string document(unsigned schema, const std::string& body) {
  return fmt::format(
      "\xef\xbb\xbf<?xml version=\"1.0\" encoding=\"utf-8\"?>\r\n<KNX xmlns:xsi=\"http://www.w3.org/2001/"
      "XMLSchema-instance\" CreatedBy=\"{}\" xmlns=\"http://knx.org/xml/project/{}\">{}</KNX>",
      schema < 12   ? "ETS4"
      : schema < 21 ? "ETS5"
                    : "ETS6",
      schema, body);
}

/// The program of the device at this place.
std::string program_id(std::size_t device) {
  return fmt::format("M-00FA_A-{:04X}-01-0001", device + 1);
}

std::string reference_of(const KnxObject& object, bool of_instance) {
  if (!object.in_module) return fmt::format("O-{0}_R-{0}", object.number);
  return fmt::format("MD-1{}_O-2-{}_R-{}", of_instance ? "_M-7_MI-1" : "", object.number, object.number);
}

std::string flags_text(const std::string& flags) {
  std::string out;
  static const std::map<char, const char*> kNames{
      {'C', "Communication"}, {'R', "Read"}, {'W', "Write"}, {'T', "Transmit"}, {'U', "Update"}};
  for (const char flag : flags) out += fmt::format(" {}Flag=\"Enabled\"", kNames.at(flag));
  return out;
}

std::string links_text(const KnxHouse& house, const KnxObject& object) {
  std::string out;
  if (house.schema >= 20) {
    for (const auto group : object.groups) out += fmt::format("{}GA-{}", out.empty() ? " Links=\"" : " ", group);
    return out.empty() ? "/>" : out + "\"/>";
  }
  for (std::size_t i = 0; i < object.groups.size(); ++i)
    out += fmt::format("<{} GroupAddressRefId=\"P-00F1-0_GA-{}\"/>", i == 0 ? "Send" : "Receive", object.groups[i]);
  return "><Connectors>" + out + "</Connectors></ComObjectInstanceRef>";
}

std::string objects_text(const KnxHouse& house, const KnxDevice& device, const std::string& program) {
  const auto prefix = house.schema < 20 ? program + "_" : std::string();
  std::string parameters, objects;
  bool modules = false;
  for (const auto& object : device.objects) {
    modules = modules || object.in_module;
    objects += fmt::format("<ComObjectInstanceRef RefId=\"{}{}\"", prefix, reference_of(object, true));
    if (!object.channel.empty()) objects += fmt::format(" ChannelId=\"{}\"", object.channel);
    if (!object.instance.empty()) objects += " " + object.instance;
    objects += links_text(house, object);
    if (!object.parameter.empty())
      parameters +=
          fmt::format("<ParameterInstanceRef RefId=\"{}_{}P-{}_R-1\" Value=\"{}\"/>", program,
                      object.in_module ? "MD-1_M-7_MI-1_" : "", object.number, xml_attribute(object.parameter));
  }
  auto out = fmt::format(
      "<ParameterInstanceRefs>{}</ParameterInstanceRefs><ComObjectInstanceRefs>{}"
      "</ComObjectInstanceRefs>",
      parameters, objects);
  if (modules)
    out +=
        "<ModuleInstances><ModuleInstance Id=\"MD-1_M-7_MI-1\" RefId=\"MD-1_M-7\"><Arguments><Argument "
        "RefId=\"MD-1_A-1\" Value=\"3\"/></Arguments></ModuleInstance></ModuleInstances>";
  return out;
}

/// `1.1.5` -> `1`, `1`, `5`.
std::vector<std::string> parts_of(std::string address) {
  std::vector<std::string> parts(1);
  for (const char c : address) {
    if (c == '.') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  parts.resize(3);
  return parts;
}

std::string topology_text(const KnxHouse& house) {
  std::map<std::string, std::map<std::string, std::string>> areas;
  for (std::size_t i = 0; i < house.devices.size(); ++i) {
    const auto& device = house.devices[i];
    const auto parts = parts_of(device.address);
    const auto address = parts[2].empty() ? std::string() : fmt::format(" Address=\"{}\"", parts[2]);
    areas[parts[0]][parts[1]] += fmt::format(
        "<DeviceInstance Id=\"P-00F1-0_DI-{0}\"{1} Name=\"{2}\" ProductRefId=\"M-00FA_H-1_P-{0}\" "
        "Hardware2ProgramRefId=\"M-00FA_H-1_HP-{0}\"><Security ToolKey=\"AAAAAAAAAAAAAAAAAAAAAA==\"/>{3}"
        "</DeviceInstance>",
        i + 1, address, xml_attribute(device.name), objects_text(house, device, program_id(i)));
  }
  std::string out;
  for (const auto& [area, lines] : areas) {
    out += fmt::format("<Area Address=\"{}\" Name=\"Area\">", area);
    for (const auto& [line, devices] : lines)
      out += fmt::format("<Line Address=\"{}\" Name=\"Line\">{}{}{}</Line>", line,
                         house.schema >= 21 ? "<Segment Number=\"0\">" : "", devices,
                         house.schema >= 21 ? "</Segment>" : "");
    out += "</Area>";
  }
  return "<Topology>" + out + "</Topology>";
}

std::string room_text(const KnxHouse& house, const std::string& room) {
  std::string out;
  for (std::size_t i = 0; i < house.devices.size(); ++i) {
    if (house.devices[i].room != room) continue;
    const auto reference = fmt::format("<DeviceInstanceRef RefId=\"P-00F1-0_DI-{}\"/>", i + 1);
    const auto* element = house.schema < 12 ? "BuildingPart" : "Space";
    out += house.devices[i].in_board
               ? fmt::format("<{0} Type=\"DistributionBoard\" Name=\"Board\">{1}</{0}>", element, reference)
               : reference;
  }
  for (std::size_t i = 0; i < house.functions.size(); ++i) {
    if (house.functions[i].room != room) continue;
    out += fmt::format("<Function Id=\"P-00F1-0_F-{}\" Name=\"{}\" Type=\"FT-1\">", i + 1,
                       xml_attribute(house.functions[i].name));
    for (const auto& [group, role] : house.functions[i].groups)
      out += fmt::format("<GroupAddressRef Name=\"\" Role=\"{}\" RefId=\"P-00F1-0_GA-{}\"/>", role, group);
    out += "</Function>";
  }
  return out;
}

/// Rooms are written as `Floor/Room`.
std::string locations_text(const KnxHouse& house) {
  std::set<std::string> rooms;
  for (const auto& device : house.devices) rooms.insert(device.room);
  for (const auto& function : house.functions) rooms.insert(function.room);
  const auto* element = house.schema < 12 ? "BuildingPart" : "Space";
  std::string out;
  for (const auto& room : rooms) {
    if (room.empty()) continue;
    const auto slash = room.find('/');
    out += fmt::format("<{0} Type=\"Floor\" Name=\"{1}\"><{0} Type=\"Room\" Name=\"{2}\">{3}</{0}></{0}>", element,
                       xml_attribute(room.substr(0, slash)), xml_attribute(room.substr(slash + 1)),
                       room_text(house, room));
  }
  const auto* list = house.schema < 12 ? "Buildings" : "Locations";
  return fmt::format("<{0}><{1} Type=\"Building\" Name=\"{2}\">{3}</{1}></{0}>", list, element,
                     xml_attribute(house.name), out);
}

std::string group_text(const KnxGroup& group, std::size_t place) {
  auto out = fmt::format("<GroupAddress Id=\"P-00F1-0_GA-{}\" Address=\"{}\" Name=\"{}\"", place, group.address,
                         xml_attribute(group.name));
  if (!group.description.empty()) out += fmt::format(" Description=\"{}\"", xml_attribute(group.description));
  if (!group.type.empty()) out += fmt::format(" DatapointType=\"{}\"", group.type);
  return out + (group.more.empty() ? "" : " " + group.more) + "/>";
}

std::string groups_text(const KnxHouse& house) {
  std::map<int, std::map<int, std::string>> ranges;
  for (std::size_t i = 0; i < house.groups.size(); ++i) {
    const auto address = house.groups[i].address;
    const int middle = house.style == "ThreeLevel" ? address >> 8 & 7 : 0;
    ranges[address >> 11][middle] += group_text(house.groups[i], i + 1);
  }
  std::string out;
  for (const auto& [main, middles] : ranges) {
    out += fmt::format("<GroupRange Name=\"Main {}\">", main);
    for (const auto& [middle, addresses] : middles)
      out += house.style == "ThreeLevel"
                 ? fmt::format("<GroupRange Name=\"Middle {}\">{}</GroupRange>", middle, addresses)
                 : addresses;
    out += "</GroupRange>";
  }
  return "<GroupAddresses><GroupRanges>" + out + "</GroupRanges></GroupAddresses>";
}

std::string hardware_xml(const KnxHouse& house) {
  std::string products, programs;
  for (std::size_t i = 0; i < house.devices.size(); ++i) {
    products += fmt::format("<Product Id=\"M-00FA_H-1_P-{0}\" Text=\"Product {0}\" OrderNumber=\"N {0}\"/>", i + 1);
    programs += fmt::format(
        "<Hardware2Program Id=\"M-00FA_H-1_HP-{}\"><ApplicationProgramRef RefId=\"{}\"/>"
        "</Hardware2Program>",
        i + 1, program_id(i));
  }
  return document(house.schema, "<ManufacturerData><Manufacturer RefId=\"M-00FA\"><Hardware><Hardware><Products>" +
                                    products + "</Products><Hardware2Programs>" + programs +
                                    "</Hardware2Programs></Hardware></Hardware></Manufacturer></ManufacturerData>");
}

/// Tables of objects and references, in the program or in its module.
std::string tables_text(const KnxDevice& device, const std::string& program, bool of_module) {
  const auto prefix = program + (of_module ? "_" : "_");
  std::string objects, references;
  for (const auto& object : device.objects) {
    if (object.in_module != of_module) continue;
    const auto reference = prefix + reference_of(object, false);
    const auto id = reference.substr(0, reference.rfind("_R-"));
    objects += fmt::format(
        "<ComObject Id=\"{}\" Name=\"\" Text=\"\" Number=\"{}\" FunctionText=\"\" ObjectSize=\"{}\" "
        "ReadFlag=\"Disabled\" WriteFlag=\"Disabled\" CommunicationFlag=\"Disabled\" TransmitFlag=\"Disabled\"/>",
        id, object.number, object.size);
    references += fmt::format("<ComObjectRef Id=\"{}\" RefId=\"{}\" Text=\"{}\" FunctionText=\"{}\"{}{}{}/>", reference,
                              id, xml_attribute(object.text), xml_attribute(object.function), flags_text(object.flags),
                              object.type.empty() ? "" : fmt::format(" DatapointType=\"{}\"", object.type),
                              object.parameter.empty() ? ""
                                                       : fmt::format(" TextParameterRefId=\"{}{}P-{}_R-1\"", prefix,
                                                                     of_module ? "MD-1_" : "", object.number));
  }
  return "<ComObjectTable>" + objects + "</ComObjectTable><ComObjectRefs>" + references + "</ComObjectRefs>";
}

std::string program_xml(const KnxHouse& house, std::size_t place) {
  const auto& device = house.devices[place];
  const auto program = program_id(place);
  return document(
      house.schema,
      fmt::format(
          "<ManufacturerData><Manufacturer RefId=\"M-00FA\"><ApplicationPrograms><ApplicationProgram Id=\"{0}\">"
          "<Static><ParameterRefs>{3}</ParameterRefs>{1}</Static><ModuleDefs><ModuleDef "
          "Id=\"{0}_MD-1\"><Arguments><Argument Id=\"{0}_MD-1_A-1\" "
          "Name=\"Number\"/></Arguments><Static>{2}</Static></ModuleDef></ModuleDefs>"
          "</ApplicationProgram></ApplicationPrograms></Manufacturer></ManufacturerData>",
          program, tables_text(device, program, false), tables_text(device, program, true), house.program_filler));
}

}  // namespace

std::string zip_of(const std::vector<ZipEntry>& entries, ZipProtection protection, const std::string& password) {
  zip_error_t error;
  ::zip_error_init(&error);
  auto* target = ::zip_source_buffer_create(nullptr, 0, 0, &error);
  auto* archive = target == nullptr ? nullptr : ::zip_open_from_source(target, ZIP_TRUNCATE, &error);
  if (archive == nullptr) throw std::runtime_error("libzip cannot make an archive");
  ::zip_source_keep(target);
  for (const auto& entry : entries) {
    auto* content = ::zip_source_buffer(archive, entry.content.data(), entry.content.size(), 0);
    const auto index = ::zip_file_add(archive, entry.name.c_str(), content, ZIP_FL_ENC_UTF_8);
    if (index < 0) throw std::runtime_error(::zip_strerror(archive));
    // libzip 1.7 checks passwords of ZipCrypto by the time of the content, not by this one.
    if (protection != ZipProtection::kZipCrypto)
      ::zip_file_set_mtime(archive, static_cast<zip_uint64_t>(index), 1'700'000'000, 0);
    if (protection != ZipProtection::kNone)
      ::zip_file_set_encryption(archive, static_cast<zip_uint64_t>(index),
                                protection == ZipProtection::kAes ? ZIP_EM_AES_256 : ZIP_EM_TRAD_PKWARE,
                                password.c_str());
  }
  if (::zip_close(archive) != 0) throw std::runtime_error(::zip_strerror(archive));
  ::zip_source_open(target);
  ::zip_source_seek(target, 0, SEEK_END);
  std::string bytes(static_cast<std::size_t>(::zip_source_tell(target)), '\0');
  ::zip_source_seek(target, 0, SEEK_SET);
  ::zip_source_read(target, bytes.data(), bytes.size());
  ::zip_source_close(target);
  ::zip_source_free(target);
  ::zip_error_fini(&error);
  return bytes;
}

std::string KnxHouse::installation_xml() const {
  return document(schema, "<Project Id=\"P-00F1\"><Installations><Installation Name=\"\">" + topology_text(*this) +
                              locations_text(*this) + groups_text(*this) + "</Installation></Installations></Project>");
}

std::string KnxHouse::project_xml() const {
  return document(schema, fmt::format("<Project Id=\"P-00F1\"><ProjectInformation Name=\"{}\" GroupAddressStyle=\"{}\" "
                                      "ProjectPassword=\"in the clear\"/></Project>",
                                      xml_attribute(name), style));
}

std::vector<ZipEntry> KnxHouse::entries() const {
  const std::string folder = "P-00F1/";
  std::vector<ZipEntry> all{{"knx_master.xml", document(schema, "<MasterData Id=\"MD-1\"/>")},
                            {"P-00F1.signature", "signature"},
                            {folder + (schema < 12 ? "Project.xml" : "project.xml"), project_xml()},
                            {folder + "0.xml", installation_xml()},
                            {"M-00FA/Hardware.xml", hardware_xml(*this)}};
  for (std::size_t i = 0; i < devices.size(); ++i)
    all.push_back({fmt::format("M-00FA/{}.xml", program_id(i)), program_xml(*this, i)});
  return all;
}

std::string KnxHouse::file() const {
  if (password.empty()) return zip_of(entries());
  std::vector<ZipEntry> outer, inner;
  for (auto& entry : entries()) {
    const bool secret = entry.name.starts_with("P-00F1/");
    if (secret) entry.name = entry.name.substr(7);
    (secret ? inner : outer).push_back(std::move(entry));
  }
  const bool aes = schema >= 21;
  const auto key =
      aes ? std::string(networks::knx::secure::archive_password(networks::knx::secure::Secret::of_text(password))
                            .value()
                            .text())
          : password;
  outer.push_back({"P-00F1.zip", zip_of(inner, aes ? ZipProtection::kAes : ZipProtection::kZipCrypto, key)});
  return zip_of(outer);
}

KnxHouse small_house(unsigned schema) {
  KnxHouse house;
  house.schema = schema;
  house.groups = {{0x0801, "Kitchen lamp"},
                  {0x0802, "Kitchen lamp answer"},
                  {0x0803, "Table", "DPST-5-1", "over the \"table\"\nbrightness"},
                  {0x0804, "Table now", "DPST-5-1"},
                  {0x0901, "Blind", "DPST-1-8", "", "Central=\"true\""},
                  {0x1001, "Outside", "DPST-9-1"},
                  {0x1002, "Comfort", "", "", "Key=\"AAAAAAAAAAAAAAAAAAAAAA==\" Security=\"On\""},
                  {0x1003, "Comfort now"},
                  {0x1004, "Unused", "DPST-1-1", "linked to nothing"}};
  house.devices = {
      {"1.1.5",
       "Switch actuator",
       "Ground floor/Cellar",
       {{1, "Output A", "Switch", "CW", "DPST-1-1", "1 Bit", {1}},
        {2, "Output A", "Status switch", "CRT", "DPST-1-1", "1 Bit", {2}},
        {3, "Output B", "Blind up/down", "CW", "", "1 Bit", {5}}},
       true},
      {"1.1.6",
       "Push button",
       "Ground floor/Kitchen",
       {{1, "Rocker {{0:1}}", "Switching", "CRT", "DPST-1-1", "1 Bit", {1}, "", "", false, "left"},
        {2, "LED", "Status", "CWU", "DPST-1-1", "1 Bit", {2}}}},
      {"1.1.7", "Weather station", "Roof/Mast", {{1, "Station", "Temperature", "CRT", "DPST-9-1", "2 Bytes", {6}}}},
      {"1.1.8",
       "Heating controller",
       "Ground floor/Kitchen",
       {{1,
         "RTC {{Number}} ({{0:...}})",
         "Setpoint temperature",
         "CWU",
         "DPST-9-1",
         "2 Bytes",
         {7},
         "",
         "",
         true,
         "bath"},
        {2,
         "RTC {{Number}} ({{0:...}})",
         "Setpoint temperature - status",
         "CRT",
         "DPST-9-1",
         "2 Bytes",
         {8},
         "",
         "",
         true,
         "bath"}}},
      {"1.1.", "Power supply", "Ground floor/Cellar"}};
  house.functions = {{"Table lamp", "Ground floor/Kitchen", {{3, "DimmingValue"}, {4, "InfoDimmingValue"}}}};
  return house;
}

KnxHouse large_house(unsigned schema, unsigned addresses, std::size_t program_filler) {
  KnxHouse house;
  house.schema = schema;
  static constexpr const char* kTypes[] = {"DPST-1-1", "DPST-1-11", "DPST-5-1", "DPST-9-1"};
  static constexpr const char* kWords[] = {"switch", "switch status", "brightness", "temperature"};
  static constexpr const char* kFlags[] = {"CW", "CRT", "CW", "CRT"};
  static constexpr const char* kSizes[] = {"1 Bit", "1 Bit", "1 Byte", "2 Bytes"};
  for (unsigned i = 0; i < addresses; ++i) {
    const auto kind = i % 4;
    house.groups.push_back({static_cast<std::uint16_t>(i + 1), fmt::format("Room {} {}", i / 4, kWords[kind]),
                            i % 8 < 4 ? kTypes[kind] : ""});
    if (i % 16 == 0) {
      const auto number = house.devices.size();
      house.devices.push_back({fmt::format("{}.{}.{}", 1 + number / 3000, number / 200 % 15, 1 + number % 200),
                               fmt::format("Actuator {}", number),
                               fmt::format("Floor {}/Room {}", number % 5, number % 50)});
    }
    auto& objects = house.devices.back().objects;
    objects.push_back({static_cast<unsigned>(objects.size()),
                       fmt::format("Channel {}", i / 2 % 8),
                       kWords[kind],
                       kFlags[kind],
                       kTypes[kind],
                       kSizes[kind],
                       {i + 1}});
  }
  for (unsigned i = 0; house.program_filler.size() < program_filler; ++i)
    house.program_filler += fmt::format("<ParameterRef RefId=\"M-00FA_A-0001_P-{}_R-{}\" Value=\"{:x}\"/>", i,
                                        i * 7 % 1009, i * 2654435761U);
  return house;
}

}  // namespace rubicon::support
