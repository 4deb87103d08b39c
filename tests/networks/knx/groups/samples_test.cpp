#include <algorithm>
#include <set>

#include "networks/knx/groups/support.h"

namespace rubicon::networks::knx::groups {
namespace {

std::string one_line(std::string text) {
  for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at)) text.replace(at, 1, "\\n");
  return text;
}

std::string type_text(const GroupEntry& entry) {
  if (!entry.dpt) return "";
  return entry.dpt->sub == dpt::DptId::kMainOnly ? std::to_string(entry.dpt->main) : to_string(*entry.dpt);
}

class Samples : public ::testing::Test {
 protected:
  void SetUp() override {
    expected_ = shared_table("flat-expected.tsv");
    if (expected_.empty()) GTEST_SKIP() << "no ../shared/data/knx/import beside the source tree";
  }

  GroupList read(const std::string& name) {
    const auto text = shared_file(name);
    EXPECT_TRUE(text) << name;
    return read_group_list(text.value_or(""));
  }

  std::vector<std::map<std::string, std::string>> expected_;
};

class FlatExports : public Samples, public ::testing::WithParamInterface<const char*> {};

TEST_P(FlatExports, GiveEveryAddressAsTheProjectHasIt) {
  const auto list = read(GetParam());
  ASSERT_EQ(list.entries.size(), expected_.size()) << texts(list.report);
  EXPECT_EQ(list.report.errors + list.report.warnings, 0U) << texts(list.report);
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    auto& row = expected_[i];
    const auto& entry = list.entries[i];
    EXPECT_EQ(to_string(entry.address, entry.notation), row["address"]);
    EXPECT_EQ(std::to_string(number(entry.address)), row["number"]);
    EXPECT_EQ(entry.name, row["name"]);
    EXPECT_EQ(entry.main_group, row["main_group"]) << row["address"];
    EXPECT_EQ(entry.middle_group, row["middle_group"]) << row["address"];
    EXPECT_EQ(type_text(entry), row["dpt"]) << row["address"];
    EXPECT_EQ(one_line(entry.description), row["description"]) << row["address"];
    EXPECT_EQ(entry.central ? "1" : "0", row["central"]) << row["address"];
    EXPECT_EQ(entry.unfiltered ? "1" : "0", row["unfiltered"]) << row["address"];
    EXPECT_EQ(entry.security, row["security"]) << row["address"];
  }
}

INSTANTIATE_TEST_SUITE_P(All, FlatExports, ::testing::Values("flat-3-1.csv", "flat-1-1.csv", "flat.xml"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

/// The group addresses of a real installation of 475 addresses.
class RealLists : public ::testing::TestWithParam<const char*> {};

TEST_P(RealLists, GiveNameAndTypeOfEveryAddress) {
  const std::string folder = "knx-secure/lists";
  const auto expected = shared_table("haido-expected.tsv", folder);
  const auto text = shared_file(GetParam(), folder);
  if (expected.empty() || !text) GTEST_SKIP() << "no ../shared/data/knx-secure/lists beside the source tree";
  const auto list = read_group_list(*text);
  std::map<std::string, const GroupEntry*> by_address;
  for (const auto& entry : list.entries) by_address.emplace(to_string(entry.address, entry.notation), &entry);
  EXPECT_EQ(by_address.size(), expected.size());
  for (auto row : expected) {
    const auto found = by_address.find(row["address"]);
    ASSERT_NE(found, by_address.end()) << row["address"];
    EXPECT_EQ(one_line(found->second->name), row["name"]) << row["address"];
    EXPECT_EQ(found->second->dpt ? to_string(*found->second->dpt) : "", row["dpt"]) << row["address"];
  }
}

INSTANTIATE_TEST_SUITE_P(All, RealLists, ::testing::Values("haido-1-1.csv", "haido-3-1.csv", "haido.xml"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

TEST_F(Samples, TheEsfGivesNamesGroupsMainTypesSizesAndListeningAddresses) {
  const auto list = read("flat.esf");
  ASSERT_EQ(list.entries.size(), expected_.size()) << texts(list.report);
  EXPECT_EQ(list.report.errors, 0U) << texts(list.report);
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    auto& row = expected_[i];
    const auto& entry = list.entries[i];
    EXPECT_EQ(to_string(entry.address, entry.notation), row["address"]);
    EXPECT_EQ(entry.name, row["name"]);
    EXPECT_EQ(entry.main_group, row["main_group"]);
    EXPECT_EQ(entry.middle_group, row["middle_group"]);
    EXPECT_EQ(type_text(entry), row["esf_dpt_main"]) << row["address"];
    EXPECT_EQ(std::to_string(entry.size_bits), row["esf_size_bits"]) << row["address"];
    std::string listen;
    for (const auto address : entry.listen) listen += to_string(address);
    EXPECT_EQ(listen, row["esf_listen"]) << row["address"];
  }
}

/// A finding of a broken file: line, level and address.
using FindingKey = std::tuple<std::size_t, std::string, std::string>;

std::set<FindingKey> findings_of(const GroupList& list) {
  std::set<FindingKey> findings;
  for (const auto& finding : list.report.findings) {
    if (finding.level == Finding::Level::kNote) continue;
    findings.emplace(finding.line, to_string(finding.level), finding.address ? to_string(*finding.address) : "");
  }
  return findings;
}

TEST_F(Samples, EveryErrorOfTheBrokenFilesIsReportedWithItsLineAndNothingElse) {
  std::map<std::string, std::set<FindingKey>> expected;
  std::map<std::string, std::set<std::pair<std::size_t, std::string>>> good;
  for (auto& row : shared_table("broken-expected.tsv")) {
    if (row["file"].find(".knxproj") != std::string::npos) continue;
    const auto line = std::stoul(row["line"]);
    auto& findings = expected[row["file"]];
    if (row["kind"] != "ok") findings.emplace(line, row["kind"], row["address"]);
    const bool imported = row["kind"] != "error" && !row["address"].empty();
    if (imported) good[row["file"]].emplace(line, row["address"]);
  }
  ASSERT_EQ(expected.size(), 5U);
  for (const auto& [file, findings] : expected) {
    const auto list = read(file);
    EXPECT_EQ(findings_of(list), findings) << file << "\n" << texts(list.report);
    std::set<std::pair<std::size_t, std::string>> imported;
    for (const auto& entry : list.entries) imported.emplace(entry.line, to_string(entry.address));
    EXPECT_EQ(imported, good[file]) << file;
  }
}

TEST_F(Samples, TheTextsOfTheReportNameTheErrors) {
  const auto csv = texts(read("broken-3-1.csv").report);
  for (const auto* words :
       {"its main group is 32, expected 0 to 31", "its middle group is 8", "its sub group is 256",
        "0/0/0 is the broadcast address", "duplicate address, the first one is kept (line 4)",
        "type 'DPST-9-x' is not a data point type: imported without a type", "imported with main type 9",
        "main type 999 unknown: imported without a type", "columns missing: imported without a type",
        "wrong number of levels: '1/300'", "empty name", "read as Windows-1252", "quote never closed"}) {
    EXPECT_NE(csv.find(words), csv.npos) << words << "\n" << csv;
  }
  EXPECT_NE(texts(read("broken-1-1.csv").report).find("no address column in the header"), std::string::npos);
  EXPECT_NE(texts(read("broken.xml").report).find("document ends inside an element"), std::string::npos);
  EXPECT_NE(texts(read("broken-entities.xml").report).find("DOCTYPE not allowed"), std::string::npos);
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
