#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>

#include "model/type_catalogue.h"
#include "networks/knx/dpt/samples.h"

namespace rubicon::networks::knx::dpt {
namespace {

const std::string kMapping = RUBICON_SOURCE_DIR "/tests/cases/types/knx_dpt.tsv";

TEST(DptId, ReadsEverySpellingInUse) {
  for (const auto* text : {"9.001", "9.1", "DPT9.001", "dpt9.001", "DPST-9-1", "dpst-9-001", "DPT-9.001"}) {
    const auto id = parse_dpt(text);
    ASSERT_TRUE(id) << text << ": " << id.error().text;
    EXPECT_EQ(*id, (DptId{9, 1})) << text;
  }
  for (const auto* text : {"9", "9.*", "DPT9", "DPT-9", "dpt-9.*"}) {
    const auto id = parse_dpt(text);
    ASSERT_TRUE(id) << text << ": " << id.error().text;
    EXPECT_EQ(*id, (DptId{9, DptId::kMainOnly})) << text;
  }
  EXPECT_EQ(*parse_dpt("14.1201"), (DptId{14, 1201}));
  EXPECT_EQ(*parse_dpt("9.60000"), (DptId{9, 60000}));
}

TEST(DptId, RefusesWhatIsNone) {
  for (const auto* text : {"",       ".",        "9.",    ".1",      "9.x",     "x",       "-1.001",   "9.-1",
                           "9.001 ", " 9.001",   "0.001", "9.65535", "9.65536", "70000.1", "9.000001", "DPT",
                           "DPST-9", "DPST-9-*", "9-1",   "9.1.1",   "+9.1",    "DPST-",   "9,001"}) {
    const auto id = parse_dpt(text);
    EXPECT_FALSE(id) << text;
    if (!id) {
      EXPECT_EQ(id.error().code, ErrorCode::kInvalid);
    }
  }
}

TEST(DptId, IsWrittenWithThreeDigitsAtLeast) {
  EXPECT_EQ(to_string(DptId{9, 1}), "9.001");
  EXPECT_EQ(to_string(DptId{14, 1201}), "14.1201");
  EXPECT_EQ(to_string(DptId{9, DptId::kMainOnly}), "9.*");
}

TEST(DptTable, HasAllRowsInOrder) {
  EXPECT_EQ(all_dpts().size(), 363U);
  EXPECT_TRUE(std::ranges::is_sorted(all_dpts(), std::ranges::less_equal{}, &Dpt::id) ||
              std::ranges::is_sorted(all_dpts(), {}, &Dpt::id));
  for (const auto& row : all_dpts()) EXPECT_EQ(find_dpt(row.id), &row) << to_string(row.id);
}

TEST(DptTable, AnUnknownSubTypeFallsBackToItsMainType) {
  const auto* type = find_dpt({9, 999});
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(to_string(type->id), "9.*");
  EXPECT_EQ(type->unit, "");
  EXPECT_EQ(std::get<double>(*decode(*type, payload(*type, "0c33"))), 21.5);
  EXPECT_EQ(find_dpt({9, DptId::kMainOnly}), type);
  EXPECT_EQ(find_dpt({31, 1}), nullptr);
  EXPECT_EQ(find_dpt({0, 1}), nullptr);
  EXPECT_EQ(find_dpt({285, 2})->id, (DptId{285, DptId::kMainOnly}));
  EXPECT_EQ(find_dpt({286, 1}), nullptr);
  EXPECT_EQ(find_dpt({65535, 65535}), nullptr);
}

TEST(DptTable, APrivateRowIsFoundByItsFullNumberOnly) {
  for (const auto id : {DptId{9, 60000}, DptId{20, 60102}, DptId{20, 60104}, DptId{20, 60105}}) {
    EXPECT_EQ(find_dpt(id)->id, id);
    EXPECT_TRUE(find_dpt(id)->name.starts_with("(private)"));
    EXPECT_EQ(find_dpt({id.main, DptId::kMainOnly})->id.sub, DptId::kMainOnly);
  }
}

std::uint16_t bits_in(const std::string& length) {
  if (length == "1..n") return 0;
  const auto number = std::stoi(length);
  return static_cast<std::uint16_t>(length.ends_with("bit") ? number : number * 8);
}

/// `0..100`, `-273..670433.28`, `±3.4028235e38`, `-2^63..2^63-1`; nothing for other texts.
std::optional<std::pair<double, double>> range_in(const std::string& text) {
  if (text.starts_with("±")) return std::pair(-std::stod(text.substr(2)), std::stod(text.substr(2)));
  if (text == "-2^63..2^63-1") return std::pair(-9223372036854775808.0, 9223372036854775808.0);
  static const std::regex kRange(R"((-?[0-9.]*[0-9])\.\.(-?[0-9.]+))");
  std::smatch match;
  if (!std::regex_match(text, match, kRange)) return std::nullopt;
  return std::pair(std::stod(match[1]), std::stod(match[2]));
}

double step_in(const std::string& text) {
  if (text == "100/255") return 100.0 / 255;
  if (text == "360/255") return 360.0 / 255;
  return text.find_first_not_of("0123456789.") == text.npos ? std::stod(text) : 0;
}

TEST(DptTable, AgreesWithTheTableOfTheSpecificationRowByRow) {
  const auto rows = rows_of(shared_file("dpt-table.tsv"));
  if (rows.empty()) GTEST_SKIP() << "no " << shared_file("dpt-table.tsv");
  ASSERT_EQ(rows.size(), all_dpts().size());
  int ranges = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [row, type] = std::pair(rows[i], all_dpts()[i]);
    SCOPED_TRACE(row[0]);
    EXPECT_EQ(to_string(type.id), row[0]);
    EXPECT_EQ(type.name, row[1]);
    EXPECT_EQ(type.meaning, row[2]);
    EXPECT_EQ(type.bits, bits_in(row[3]));
    EXPECT_EQ(type.unit, row[5]);
    const bool counts = type.form == Form::kEnumeration || type.form == Form::kBit;
    const bool composed = type.form == Form::kRecord || type.form == Form::kTime || type.form == Form::kDate;
    if (!composed) {
      EXPECT_DOUBLE_EQ(type.step, counts ? 1 : step_in(row[7]));
    }
    const auto range = range_in(row[6]);
    if (!range || type.form == Form::kDateTime) continue;
    ++ranges;
    EXPECT_FLOAT_EQ(static_cast<float>(type.minimum), static_cast<float>(range->first));
    EXPECT_DOUBLE_EQ(type.maximum, range->second);
  }
  EXPECT_GT(ranges, 150);
}

TEST(DptTable, NamesTheTypesOfTheCatalogueThatTheMappingLists) {
  const TypeCatalogue types;
  std::map<std::string, std::string> mapping;
  for (const auto& row : rows_of(kMapping)) mapping[row[0]] = row[1];
  ASSERT_FALSE(mapping.empty());
  for (const auto* type : all_and_mains()) {
    SCOPED_TRACE(to_string(type->id));
    const auto own = mapping.find(to_string(type->id));
    const auto found = own == mapping.end() ? mapping.find(std::to_string(type->id.main) + ".*") : own;
    ASSERT_NE(found, mapping.end());
    auto name = found->second;
    ASSERT_NE(types.find(type->sensor), nullptr);
    EXPECT_EQ(types.find(type->sensor)->name, name);
    if (name.ends_with("Input")) name = name.substr(0, name.size() - 5) + "Output";
    ASSERT_NE(types.find(type->actuator), nullptr);
    EXPECT_EQ(types.find(type->actuator)->name, name);
    EXPECT_EQ(types.find(type->actuator)->data, types.find(type->sensor)->data);
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::dpt
