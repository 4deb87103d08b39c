#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "config/rights_config.h"
#include "config/yaml.h"
#include "rights/rights.h"

namespace rubicon::rights {

inline std::string case_text(const std::string& name) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/rights/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::vector<Rule> rules_in(const std::string& yaml) {
  const auto root = config::parse_yaml(yaml, "home.yaml");
  if (!root) return {};
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto setup = config::read_rights(reader);
  return setup && errors.empty() ? setup->rules : std::vector<Rule>{};
}

/// The members of tests/cases/rights/table.txt.
inline std::map<std::string, tuples::Member> members() {
  return {{"anna", {.name = "anna", .roles = {"operator", "admin"}}},
          {"robot", {.name = "robot"}},
          {"panel", {.name = "panel"}},
          {"lab", {.name = "lab"}},
          {"tablet", {.name = "tablet", .roles = {"kids"}}},
          {"two", {.name = "two", .ids = {{2, 2}, {0x200000, 0x2fffff}}}},
          {"three", {.name = "three", .ids = {{3, 3}, {0x300000, 0x3fffff}}}},
          {"lan", {.name = "lan"}},
          {"peis", {.name = "peis"}}};
}

struct Row {
  std::string member, right, key, answer, rule;
};

inline std::vector<Row> table() {
  std::istringstream lines(case_text("table.txt"));
  std::vector<Row> rows;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Row row;
    if (!line.starts_with('#') && words >> row.member >> row.right >> row.key >> row.answer >> row.rule)
      rows.push_back(row);
  }
  return rows;
}

}  // namespace rubicon::rights
