#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "networks/knx/project/support.h"

// A program of its own, because it counts the bytes of every allocation there is.

namespace {

std::size_t live = 0, peak = 0;

void* counted(std::size_t size) {
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) std::abort();
  live += ::malloc_usable_size(memory);
  peak = std::max(peak, live);
  return memory;
}
void released(void* memory) {
  if (memory != nullptr) live -= ::malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size);
}
void* operator new[](std::size_t size) {
  return counted(size);
}
void operator delete(void* memory) noexcept {
  released(memory);
}
void operator delete[](void* memory) noexcept {
  released(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  released(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  released(memory);
}

namespace rubicon::networks::knx::project {
namespace {

using ::testing::HasSubstr;

/// What these tests allow a project to keep.
constexpr std::size_t kKept = std::size_t{4} << 20U;
const std::string kPad(200, 'A');

/// A text of some 210 bytes that no other has.
std::string text_of(const char* what, int number) {
  return fmt::format("{}{}{}", what, number, kPad);
}

std::string xml_of(const std::string& body) {
  return "<KNX xmlns=\"http://knx.org/xml/project/23\">" + body + "</KNX>";
}

std::string with_bus(const std::string& devices, const std::string& more = "") {
  return "<Installation><Topology><Area Address=\"1\"><Line Address=\"1\">" + devices + "</Line></Area></Topology>" +
         more +
         "<GroupAddresses><GroupRange Name=\"m\"><GroupAddress Id=\"GA-1\" Address=\"1\" "
         "Name=\"a\"/></GroupRange></GroupAddresses></Installation>";
}

std::string device_with(const std::string& content) {
  return "<DeviceInstance Id=\"DI-1\" Address=\"1\" Hardware2ProgramRefId=\"M-00FA_HP-1\">" + content +
         "</DeviceInstance>";
}

std::string zipped(const std::string& installation, const std::string& program = "") {
  return support::zip_of({{"knx_master.xml", xml_of("")},
                          {"P-00F1/project.xml", xml_of("<ProjectInformation Name=\"x\"/>")},
                          {"P-00F1/0.xml", xml_of(installation)},
                          {"M-00FA/Hardware.xml", xml_of("<Hardware2Program Id=\"M-00FA_HP-1\"><ApplicationProgramRef "
                                                         "RefId=\"M-00FA_A-1\"/></Hardware2Program>")},
                          {"M-00FA/M-00FA_A-1.xml", xml_of(program)}});
}

template <class Make>
std::string repeated(int count, Make make) {
  std::string out;
  for (int i = 0; i < count; ++i) out += make(i);
  return out;
}

/// Reads the file and returns the most memory that this took, besides the file.
std::size_t peak_of(const std::string& file, std::size_t kept, Result<Project>& project) {
  auto source = file_with(file);
  const auto before = live;
  peak = live;
  project = read_project(std::move(source), "house.knxproj", {nullptr, {}, kept});
  return peak - before;
}

void expect_refused(const std::string& file) {
  Result<Project> project = fail(ErrorCode::kBusy, "");
  const auto took = peak_of(file, kKept, project);
  ASSERT_FALSE(project);
  EXPECT_THAT(project.error().text, HasSubstr("more than 4194304 bytes of names and texts"));
  EXPECT_LT(took, 2 * kKept);
}

TEST(ProjectMemory, TextsOfProgramsAreBounded) {
  const auto program = repeated(10'000, [](int i) {
    const auto traits =
        fmt::format(" Text=\"{}\" FunctionText=\"{}\" TextParameterRefId=\"{}\" ObjectSize=\"{}\" DatapointType=\"{}\"",
                    text_of("t", i), text_of("f", i), text_of("p", i), text_of("s", i), text_of("DPST-9-1 ", i));
    return fmt::format("<ComObject Id=\"M-00FA_A-1_O-{0}\"{1}/><ComObjectRef Id=\"M-00FA_A-1_O-{0}_R-1\"/>", i, traits);
  });
  const auto objects = repeated(
      10'000, [](int i) { return fmt::format("<ComObjectInstanceRef RefId=\"O-{}_R-1\" Links=\"GA-1\"/>", i); });
  expect_refused(zipped(with_bus(device_with(objects)), program));
}

TEST(ProjectMemory, ArgumentsOfModulesAreBounded) {
  const auto arguments = repeated(30'000, [](int i) {
    return fmt::format("<Argument RefId=\"{}\" Value=\"{}\"/>", text_of("a", i), text_of("v", i));
  });
  expect_refused(
      zipped(with_bus(device_with("<ModuleInstance Id=\"MD-1_M-1_MI-1\">" + arguments + "</ModuleInstance>"))));
}

TEST(ProjectMemory, TextsAndLinksOfObjectsAreBounded) {
  expect_refused(zipped(with_bus(device_with(repeated(10'000, [](int i) {
    return fmt::format(
        "<ComObjectInstanceRef RefId=\"O-{}\" ChannelId=\"{}\" FunctionText=\"{}\" TextParameterRefId=\"{}\" "
        "ObjectSize=\"{}\" Links=\"{} {}\"/>",
        i, text_of("c", i), text_of("f", i), text_of("p", i), text_of("s", i), text_of("l", i), text_of("m", i));
  })))));
}

TEST(ProjectMemory, DevicesAreBounded) {
  expect_refused(zipped(with_bus(repeated(30'000, [](int i) {
    return fmt::format("<DeviceInstance Id=\"{}\" Address=\"{}\" Hardware2ProgramRefId=\"{}\"/>", text_of("d", i),
                       i % 255, text_of("M-1_h", i));
  }))));
}

TEST(ProjectMemory, FunctionsAndRoomsAreBounded) {
  const auto members = repeated(30'000, [](int i) {
    return fmt::format("<GroupAddressRef RefId=\"{}\" Role=\"{}\"/>", text_of("g", i), text_of("r", i));
  });
  expect_refused(zipped(with_bus(
      "", "<Locations><Space Name=\"b\"><Function Id=\"F-1\">" + members + "</Function></Space></Locations>")));
  const auto rooms = repeated(30'000, [](int i) {
    return fmt::format("<Space Name=\"{}\"><DeviceInstanceRef RefId=\"{}\"/></Space>", text_of("r", i),
                       text_of("d", i));
  });
  expect_refused(zipped(with_bus("", "<Locations><Space Name=\"b\">" + rooms + "</Space></Locations>")));
}

TEST(ProjectMemory, NamesOfAddressesAndTheirGroupsAreBounded) {
  const auto addresses = repeated(30'000, [](int i) { return fmt::format("<GroupAddress Address=\"{}\"/>", i + 1); });
  expect_refused(
      zipped("<Installation><GroupRange Name=\"" + kPad + kPad + "\">" + addresses + "</GroupRange></Installation>"));
}

/// What is not kept costs nothing: values of parameters, products, texts of objects without links.
TEST(ProjectMemory, WhatIsNotUsedIsNotKept) {
  const auto unused = repeated(30'000, [](int i) {
    return fmt::format("<ComObjectInstanceRef RefId=\"O-{}\"/><ParameterInstanceRef RefId=\"{}\" Value=\"{}\"/>", i,
                       text_of("p", i), text_of("v", i));
  });
  Result<Project> project = fail(ErrorCode::kBusy, "");
  const auto took = peak_of(zipped(with_bus(device_with(unused))), kKept, project);
  EXPECT_TRUE(project) << project.error().text;
  EXPECT_LT(took, std::size_t{1} << 20U);
}

TEST(ProjectMemory, TheLargestHouseIsWithinTheBound) {
  constexpr unsigned kAddresses = 65'535;
  Result<Project> project = fail(ErrorCode::kBusy, "");
  const auto took = peak_of(support::large_house(23, kAddresses).file(), kMaxKept, project);
  ASSERT_TRUE(project) << project.error().text;
  EXPECT_EQ(project->list.entries.size(), kAddresses);
  EXPECT_LT(took, kAddresses * 2'000U);
}

}  // namespace
}  // namespace rubicon::networks::knx::project
