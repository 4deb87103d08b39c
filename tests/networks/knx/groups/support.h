#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

inline wire::GroupAddress ga(std::string_view text) {
  return wire::parse_group(text).value();
}

inline dpt::DptId dpt(std::string_view text) {
  return dpt::parse_dpt(text).value();
}

inline std::string shared_folder(const std::string& folder = "knx/import") {
  return RUBICON_SOURCE_DIR "/../shared/data/" + folder + "/";
}

/// Content of a file of the sample projects; nothing if they are not beside the source tree.
inline std::optional<std::string> shared_file(const std::string& name, const std::string& folder = "knx/import") {
  std::ifstream file(shared_folder(folder) + name, std::ios::binary);
  if (!file) return {};
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Rows of a table with a header line, by column name.
inline std::vector<std::map<std::string, std::string>> shared_table(const std::string& name,
                                                                    const std::string& folder = "knx/import") {
  std::vector<std::map<std::string, std::string>> rows;
  const auto text = shared_file(name, folder);
  if (!text) return rows;
  std::istringstream lines(*text);
  std::vector<std::string> header;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, '\t');) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      continue;
    }
    auto& row = rows.emplace_back();
    cells.resize(header.size());
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = cells[i];
  }
  return rows;
}

inline std::string texts(const Report& report) {
  return report_text(report);
}

/// Findings of a level about an address or a line, for counting.
inline std::vector<Finding> findings(const Report& report, Finding::Level level) {
  std::vector<Finding> out;
  for (const auto& finding : report.findings) {
    if (finding.level == level) out.push_back(finding);
  }
  return out;
}

}  // namespace rubicon::networks::knx::groups
