#include "networks/zigbee/exposes/type_table.h"

#include <algorithm>
#include <map>

#include "model/units.h"
#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

const Type& type_of_row(const TypeRow& row) {
  static const TypeCatalogue types;
  static const Type kNone;
  const auto* type = types.find(row.type);
  EXPECT_NE(type, nullptr) << row.name << " becomes " << row.type;
  return type == nullptr ? kNone : *type;
}

bool has_data(LeafForm form, model::DataType data) {
  using enum model::DataType;
  switch (form) {
    case LeafForm::kNumeric: return data == kReal || data == kInteger;
    case LeafForm::kBinary: return data == kBoolean;
    case LeafForm::kEnum: return data == kEnumeration;
    case LeafForm::kText: return data == kText;
    case LeafForm::kList:
    case LeafForm::kComposite: break;
  }
  return data == kJson;
}

bool converts(const TypeRow& row, const Type& type) {
  if (row.scale != Scale::kSame) return type.unit == "%";
  if (row.unit == type.unit || row.unit.empty() || model::conversion(row.unit, type.unit)) return true;
  return (row.unit == "%{LEL}" && type.unit == "%") ||
         (type.unit == "1" && (row.unit == "%" || row.unit == "mired" || row.unit.starts_with('{')));
}

TEST(TypeTable, EachRowNamesATypeOfTheCatalogueThatCanHoldItsValues) {
  for (const auto& row : type_rows()) {
    const auto& type = type_of_row(row);
    EXPECT_EQ(type.name, row.type) << "a former name";
    EXPECT_TRUE(has_data(row.form, type.data)) << row.name << " as " << row.type;
    EXPECT_TRUE(converts(row, type)) << row.name << ": " << row.unit << " to " << type.unit;
  }
}

TEST(TypeTable, WordsAreThoseOfTheType) {
  for (const auto& row : type_rows()) {
    const auto& type = type_of_row(row);
    if (row.form != LeafForm::kEnum) continue;
    EXPECT_EQ(row.words.empty(), type.words.empty()) << row.name << " as " << row.type;
    std::string_view words = row.words;
    while (!words.empty()) {
      const auto entry = words.substr(0, words.find(','));
      const std::string word(entry.substr(0, entry.find('=')));
      EXPECT_TRUE(TypeCatalogue::check(type, Value(word))) << row.name << ": " << word;
      EXPECT_EQ(type_word(row, leaf_word(row, word)), word) << row.name;
      words.remove_prefix(std::min(words.size(), entry.size() + 1));
    }
  }
}

/// A row that an earlier one hides would never count.
TEST(TypeTable, NoRowComesTwice) {
  std::set<std::string> rows;
  for (const auto& row : type_rows()) {
    const auto key = std::string(row.group) + '|' + std::string(row.name) + '|' + std::string(row.unit) + '|' +
                     std::to_string(int(row.form)) + std::to_string(int(row.use)) + (row.words.empty() ? "" : "words");
    EXPECT_TRUE(rows.insert(key).second) << key;
  }
}

/// tests/cases/types/zigbee_units.tsv lists for all networks what a unit is where nothing else is known.
TEST(TypeTable, RowsByUnitAgreeWithTheTypesOfUnits) {
  const std::map<std::string, std::string> spelled{{"kW.h", "kWh"},   {"V.A", "VA"},     {"kvar.h", "kvarh"},
                                                   {"[ppm]", "ppm"},  {"/cm3", "1/cm3"}, {"/min", "1/min"},
                                                   {"dB[mW]", "dBm"}, {"[pH]", "pH"},    {"%{LEL}", "%LEL"}};
  const auto types = rows_of_cases("../types/zigbee_units.tsv");
  ASSERT_FALSE(types.empty());
  for (const auto& row : type_rows()) {
    if (row.name != "*" || row.unit == "K") continue;  // kelvins of a difference, not of light
    const auto code =
        spelled.contains(std::string(row.unit)) ? spelled.at(std::string(row.unit)) : std::string(row.unit);
    const auto known = std::find_if(types.begin(), types.end(), [&](const auto& one) { return one[0] == code; });
    ASSERT_NE(known, types.end()) << code;
    EXPECT_EQ(known->at(1), row.type) << code;
  }
}

TEST(TypeTable, TheOtherEndFindsTheLeafOfAType) {
  const auto* lamp = row_of_type("lamp");
  ASSERT_NE(lamp, nullptr);
  EXPECT_EQ(lamp->group, "light");
  EXPECT_EQ(lamp->name, "state");
  const auto* blind = row_of_type("blindPosition");
  ASSERT_NE(blind, nullptr);
  EXPECT_EQ(blind->scale, Scale::kClosed);
  const auto* mode = row_of_type("hvacController");
  ASSERT_NE(mode, nullptr);
  EXPECT_EQ(leaf_word(*mode, "fan"), "fan_only");
  EXPECT_EQ(leaf_word(*row_of_type("lock"), "on"), "LOCK");
  EXPECT_EQ(leaf_word(*mode, "sauna"), "");
  EXPECT_EQ(row_of_type("windForce"), nullptr) << "no device of Zigbee2MQTT has it";
  for (const auto& row : type_rows()) {
    const auto* first = row_of_type(row.type);
    ASSERT_NE(first, nullptr);
    EXPECT_EQ(first->type, row.type);
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
