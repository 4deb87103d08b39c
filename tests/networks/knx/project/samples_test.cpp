#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/project/support.h"
#include "networks/knx/project/usage.h"

namespace rubicon::networks::knx::project {
namespace {

using Json = nlohmann::json;
using Row = std::map<std::string, std::string>;

constexpr const char* kFolder = "knx-secure/knxproj";

/// Public projects of ETS 4 to 6 (their results: xknxproject, and a second reader where that one has none).
class ProjectSamples : public ::testing::Test {
 protected:
  void SetUp() override {
    files_ = groups::shared_table("files.tsv", kFolder);
    if (files_.empty()) GTEST_SKIP() << "no ../shared/data/" << kFolder << " beside the source tree";
  }

  Result<Project> read(Row& row) {
    const auto content = groups::shared_file(row["file"], kFolder);
    EXPECT_TRUE(content) << row["file"];
    return read_bytes(content.value_or(""), row["password"]);
  }

  /// Calls `check` with each project that has a result as JSON.
  template <class Check>
  void with_results(Check check) {
    int found = 0;
    for (auto& row : files_) {
      const auto stem = row["file"].substr(0, row["file"].rfind('.'));
      const auto json = groups::shared_file(stem + ".json", kFolder);
      if (!json) continue;
      const auto project = read(row);
      ASSERT_TRUE(project) << project.error().text;
      SCOPED_TRACE(stem);
      check(*project, Json::parse(*json));
      ++found;
    }
    EXPECT_EQ(found, 3);
  }

  std::vector<Row> files_;
};

/// A field of the table, in which line ends and backslashes are escaped, as an import has it.
std::string field_of(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && i + 1 < text.size();
    out += !escape ? text[i] : text[i + 1] == 'n' ? '\n' : text[i + 1];
    if (escape) ++i;
  }
  return groups::clean_text(out, groups::kMaxFieldBytes);
}

TEST_F(ProjectSamples, GiveEveryGroupAddress) {
  std::map<std::string, std::vector<Row>> expected;
  for (auto& row : groups::shared_table("expected.tsv", kFolder)) expected[row["file"]].push_back(row);
  int read_files = 0;
  for (auto& file : files_) {
    if (file["result"] != "ok") continue;
    SCOPED_TRACE(file["file"]);
    const auto project = read(file);
    ASSERT_TRUE(project) << project.error().text;
    ++read_files;
    EXPECT_EQ(project->name, file["project_name"]);
    EXPECT_EQ(std::to_string(project->schema), file["schema"]);
    EXPECT_EQ(project->was_protected, file["protection"] != "none");
    auto& rows = expected[file["file"]];
    EXPECT_EQ(std::to_string(project->list.entries.size()), file["addresses"]);
    ASSERT_EQ(project->list.entries.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto& entry = project->list.entries[i];
      auto& row = rows[i];
      EXPECT_EQ(to_string(entry.address, entry.notation), row["address"]);
      EXPECT_EQ(std::to_string(number(entry.address)), row["number"]);
      EXPECT_EQ(entry.name, field_of(row["name"]));
      EXPECT_EQ(entry.main_group, row["main_group"]) << row["address"];
      EXPECT_EQ(entry.middle_group, row["middle_group"]) << row["address"];
      EXPECT_EQ(entry.dpt ? to_string(*entry.dpt) : "", row["dpt"]) << row["address"];
      EXPECT_EQ(entry.description, field_of(row["description"])) << row["address"];
    }
  }
  EXPECT_EQ(read_files, 8);
}

TEST_F(ProjectSamples, CountDevicesAndFunctions) {
  for (auto& file : files_) {
    if (file["result"] != "ok") continue;
    const auto project = read(file);
    ASSERT_TRUE(project) << project.error().text;
    std::size_t devices = 0, functions = 0;
    for (const auto& installation : project->installations) {
      devices += installation.devices.size();
      functions += installation.functions.size();
    }
    EXPECT_EQ(std::to_string(devices), file["devices"]) << file["file"];
    EXPECT_EQ(std::to_string(functions), file["functions"]) << file["file"];
  }
}

TEST_F(ProjectSamples, DamagedOnesAreRefusedOrReported) {
  for (auto& file : files_) {
    if (file["result"] == "ok") continue;
    const auto project = read(file);
    if (file["file"].find("Incomplete") != std::string::npos) {
      EXPECT_EQ(project.error().code, ErrorCode::kInvalid);
    } else {
      ASSERT_TRUE(project) << project.error().text;
      EXPECT_TRUE(project->list.entries.empty());
      EXPECT_EQ(project->list.report.errors, 1U) << report_text(project->list.report);
    }
  }
}

TEST_F(ProjectSamples, NeedTheirPassword) {
  int checked = 0;
  for (auto& file : files_) {
    if (file["password"].empty()) continue;
    const auto content = groups::shared_file(file["file"], kFolder).value();
    EXPECT_EQ(error_of(content).code, ErrorCode::kRefused) << file["file"];
    EXPECT_EQ(error_of(content, "Test").code, ErrorCode::kRefused) << file["file"];
    ++checked;
  }
  EXPECT_EQ(checked, 2);
}

TEST_F(ProjectSamples, GiveTheDevices) {
  with_results([](const Project& project, const Json& json) {
    std::set<std::string> found;
    for (const auto& device : project.installations.at(0).devices) {
      const auto address = to_string(device.address.value());
      found.insert(address);
      ASSERT_TRUE(json["devices"].contains(address)) << address;
      const auto& expected = json["devices"][address];
      EXPECT_EQ(device.program, expected["application"].get<std::string>());
    }
    EXPECT_EQ(found.size(), json["devices"].size());
  });
}

/// `1.1.7/MD-2_M-20_MI-1_O-2_R-3`, as the results name it.
std::string key_of(const Device& device, const LinkedObject& object) {
  std::string id(object.id.substr(device.program.size() + 1));
  if (!object.module.empty()) id.replace(0, id.find('_'), object.module);
  return fmt::format("{}/{}", to_string(device.address.value()), id);
}

std::string types_text(const Json& types) {
  std::string out;
  for (const auto& type : types)
    out += type["sub"].is_null() ? fmt::format("{}.* ", type["main"].get<int>())
                                 : fmt::format("{}.{:03} ", type["main"].get<int>(), type["sub"].get<int>());
  return out;
}

void expect_object(const Project& project, const LinkedObject& object, const Json& expected) {
  const auto& traits = object.traits;
  EXPECT_EQ(traits.text, expected["text"].get<std::string>());
  EXPECT_EQ(traits.function_text, expected["function_text"].get<std::string>());
  EXPECT_EQ(traits.size, expected["object_size"].get<std::string>());
  const auto& flags = expected["flags"];
  EXPECT_EQ(traits.communication.value_or(false), flags["communication"].get<bool>());
  EXPECT_EQ(traits.read.value_or(false), flags["read"].get<bool>());
  EXPECT_EQ(traits.write.value_or(false), flags["write"].get<bool>());
  EXPECT_EQ(traits.transmit.value_or(false), flags["transmit"].get<bool>());
  std::string types;
  for (const auto type : object_types(traits.types, traits.size)) types += to_string(type) + " ";
  EXPECT_EQ(types, types_text(expected["dpts"]));
  std::multiset<std::string> links, wanted;
  for (const auto& address : project.installations[0].addresses) {
    for (const auto& link : object.links) {
      if (link != address.id) continue;
      const auto value = wire::GroupAddress(std::stoi(std::string(address.number)));
      links.insert(to_string(value, project.list.report.notation));
    }
  }
  for (const auto& link : expected["group_address_links"]) wanted.insert(link.get<std::string>());
  EXPECT_EQ(links, wanted);
}

TEST_F(ProjectSamples, GiveTheCommunicationObjects) {
  with_results([](const Project& project, const Json& json) {
    std::size_t found = 0;
    for (const auto& device : project.installations.at(0).devices) {
      for (const auto& object : device.objects) {
        const auto key = key_of(device, object);
        SCOPED_TRACE(key);
        ASSERT_TRUE(json["communication_objects"].contains(key));
        expect_object(project, object, json["communication_objects"][key]);
        ++found;
      }
    }
    EXPECT_EQ(found, json["communication_objects"].size());
  });
}

TEST_F(ProjectSamples, GiveFunctionsAndSecuredAddresses) {
  with_results([](const Project& project, const Json& json) {
    for (const auto& entry : project.list.entries) {
      const auto& expected = json["group_addresses"][to_string(entry.address, entry.notation)];
      EXPECT_EQ(entry.secured, expected["data_secure"].get<bool>()) << entry.name;
    }
    const auto& functions = project.installations.at(0).functions;
    ASSERT_EQ(functions.size(), json["functions"].size());
    for (const auto& function : functions) {
      const auto& expected = json["functions"][std::string(function.id)];
      EXPECT_EQ(function.name, expected["name"].get<std::string>());
      ASSERT_EQ(function.members.size(), expected["group_addresses"].size());
      std::multiset<std::string> roles, wanted;
      for (const auto& member : function.members) roles.emplace(member.role);
      for (const auto& member : expected["group_addresses"]) wanted.insert(member["role"].get<std::string>());
      EXPECT_EQ(roles, wanted);
    }
  });
}

TEST_F(ProjectSamples, FlagsAndRolesDecideKindsAndStates) {
  for (auto& file : files_) {
    if (file["file"] != "testprojekt-ets6-functions.knxproj") continue;
    const auto project = read(file).value();
    const auto imported = groups::import_list(project.list);
    ASSERT_EQ(imported.points.size(), 1U);
    EXPECT_EQ(imported.points[0].kind, Kind::kActuator);
    EXPECT_EQ(imported.points[0].state, groups::ga("0/0/2"));
    EXPECT_EQ(imported.points[0].room, "Livingroom");
    EXPECT_EQ(imported.report.paired_by_project, 1U);
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::project
