#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <vector>

#include "model/type_catalogue.h"

// Every kind of value that KNX and Zigbee devices speak of has a type, or is listed as open (tests/cases/types).

namespace rubicon::model {
namespace {

const std::string kShared = RUBICON_SOURCE_DIR "/../shared/data/";
const std::string kCases = RUBICON_SOURCE_DIR "/tests/cases/types/";

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (line.ends_with('\r')) line.pop_back();
    lines.push_back(line);
  }
  if (!lines.empty()) lines.erase(lines.begin());  // the names of the columns
  return lines;
}

std::map<std::string, std::string> mapping_of(const std::string& file) {
  std::map<std::string, std::string> mapping;
  for (const auto& line : lines_of(kCases + file)) {
    const auto tab = line.find('\t');
    EXPECT_NE(tab, line.npos) << line;
    if (tab == line.npos) continue;
    EXPECT_TRUE(mapping.emplace(line.substr(0, tab), line.substr(tab + 1)).second) << "twice: " << line;
  }
  EXPECT_FALSE(mapping.empty()) << file;
  return mapping;
}

/// Column three of a line of comma separated values; none of the first three is quoted with a comma inside.
std::string canonical_unit(const std::string& line) {
  const auto second = line.find(',', line.find(',') + 1) + 1;
  return line.substr(second, line.find(',', second) - second);
}

void expect_types(const std::map<std::string, std::string>& mapping) {
  const TypeCatalogue types;
  for (const auto& [what, name] : mapping) {
    EXPECT_TRUE(name == "open" || types.find(name) != nullptr) << what << " is mapped to " << name;
  }
}

TEST(TypeMapping, NamesOnlyTypesThatAreThere) {
  expect_types(mapping_of("knx_dpt.tsv"));
  expect_types(mapping_of("zigbee_units.tsv"));
}

TEST(TypeMapping, CoversEveryKnxDatapointType) {
  const auto rows = lines_of(kShared + "knx/dpt-table.tsv");
  if (rows.empty()) GTEST_SKIP() << "no " << kShared << "knx/dpt-table.tsv";
  const auto mapping = mapping_of("knx_dpt.tsv");
  for (const auto& row : rows) {
    const auto dpt = row.substr(0, row.find('\t'));
    const auto main_type = dpt.substr(0, dpt.find('.')) + ".*";
    EXPECT_TRUE(mapping.contains(dpt) || mapping.contains(main_type)) << row;
  }
}

TEST(TypeMapping, CoversEveryZigbeeUnit) {
  const auto rows = lines_of(kShared + "zigbee/units.csv");
  if (rows.empty()) GTEST_SKIP() << "no " << kShared << "zigbee/units.csv";
  const auto mapping = mapping_of("zigbee_units.tsv");
  for (const auto& row : rows) EXPECT_TRUE(mapping.contains(canonical_unit(row))) << row;
}

}  // namespace
}  // namespace rubicon::model
