#include <nlohmann/json.hpp>

#include "base/text.h"
#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

MappedPoint point_of(const std::string& expose) {
  const auto definition = map_definition("[" + expose + "]");
  EXPECT_EQ(definition.leaves.size(), 1U) << expose;
  return definition.points.at(0);
}

/// `real 21.5`; an error as its code and text.
std::string result_text(const Result<Value>& value) {
  constexpr std::string_view kKinds[] = {"nothing", "bool", "int", "real", "text", "json"};
  if (!value) return fmt::format("{}: {}", base::to_string(value.error().code), value.error().text);
  const auto text = to_text(*value);
  return fmt::format("{}{}{}", kKinds[value->index()], text.empty() ? "" : " ", text);
}

Value value_of(const std::string& text) {
  const auto kind = text.substr(0, text.find(' '));
  const auto rest = kind == text ? std::string() : text.substr(kind.size() + 1);
  if (kind == "bool") return rest == "on";
  if (kind == "int") return base::parse_number<std::int64_t>(rest).value_or(-1);
  if (kind == "real") return base::parse_number<double>(rest).value_or(-1);
  if (kind == "text") return rest;
  if (kind == "json") return Json{rest};
  return {};
}

TEST(StateValues, FollowTheCases) {
  const auto rows = rows_of_cases("state_values.tsv");
  ASSERT_GT(rows.size(), 70U);
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 3U) << row[0];
    const auto& value = row[2];
    EXPECT_EQ(result_text(decode(point_of(row[0]), row[1])), value) << row[0] << "\t" << row[1];
  }
}

TEST(Commands, FollowTheCases) {
  const auto rows = rows_of_cases("commands.tsv");
  ASSERT_GT(rows.size(), 60U);
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 3U) << row[0];
    const auto sent = encode(point_of(row[0]), value_of(row[1]));
    const auto json = sent ? *sent : result_text(fail(sent.error()));
    const auto& expected = row[2];
    EXPECT_EQ(json, expected) << row[0] << "\t" << row[1];
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
