#include "model/type_catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "model/type_tables.h"

namespace rubicon::model {
namespace {

const Type& type_of(std::string_view name) {
  static const TypeCatalogue types;
  static const Type kNone;
  const auto* type = types.find(name);
  EXPECT_NE(type, nullptr) << name;
  return type ? *type : kNone;
}

Value parsed(std::string_view type, std::string_view text) {
  auto value = TypeCatalogue::parse(type_of(type), text);
  EXPECT_TRUE(value) << value.error().text;
  return value.value_or(Value());
}

Error parse_error(std::string_view type, std::string_view text) {
  const auto value = TypeCatalogue::parse(type_of(type), text);
  return value ? Error{ErrorCode::kBusy, "accepted"} : value.error();
}

Error check_error(std::string_view type, const Value& value) {
  const auto fits = TypeCatalogue::check(type_of(type), value);
  return fits ? Error{ErrorCode::kBusy, "accepted"} : fits.error();
}

SiteType site_type(std::uint16_t id, std::string name) {
  SiteType type;
  type.id = id;
  type.name = std::move(name);
  return type;
}

TEST(TypeCatalogue, KnowsAtLeast150Types) {
  EXPECT_GE(TypeCatalogue().all().size(), 150U);
}

TEST(TypeCatalogue, NoTwoTypesShareANameOrAnId) {
  const TypeCatalogue types;
  std::set<std::string_view> names;
  std::set<TypeId> ids;
  for (const auto* type : types.all()) {
    EXPECT_TRUE(names.insert(type->name).second) << type->name;
    EXPECT_TRUE(ids.insert(type->id).second) << type->name;
    EXPECT_EQ(types.find(type->id), type);
    EXPECT_EQ(types.find(type->name), type);
  }
}

TEST(TypeCatalogue, NamesAreLettersDigitsAndUnderscores) {
  const TypeCatalogue types;
  for (const auto* type : types.all()) {
    EXPECT_TRUE(std::isalpha(static_cast<unsigned char>(type->name.at(0)))) << type->name;
    EXPECT_TRUE(std::all_of(type->name.begin(), type->name.end(), [](unsigned char c) {
      return std::isalnum(c) || c == '_';
    })) << type->name;
  }
}

TEST(TypeCatalogue, EveryTypeSaysWhatItMeans) {
  const TypeCatalogue types;
  const std::set<std::string_view> words_of_points = {
      "enumerationInput", "enumerationOutput", "action",        "effect",        "identify",   "thermostatMode",
      "preset",           "fanMode",           "motionState",   "airQuality",    "melody",     "alarmVolume",
      "motorState",       "keypadLockout",     "indicatorMode", "backlightMode", "deviceMode", "switchType",
      "namedScene"};
  for (const auto* type : types.all()) {
    EXPECT_FALSE(type->quantity.empty()) << type->name;
    EXPECT_FALSE(type->unit.empty()) << type->name;
    EXPECT_LE(type->minimum, type->maximum) << type->name;
    EXPECT_EQ(type->data == DataType::kEnumeration,
              words_of_points.contains(type->name) || (!type->words.empty() && type->data != DataType::kBoolean))
        << type->name;
  }
}

TEST(TypeCatalogue, WordsOfATypeAreDifferent) {
  const TypeCatalogue types;
  for (const auto* type : types.all()) {
    std::set<std::string> words;
    std::string rest(type->words);
    while (!rest.empty()) {
      const auto word = rest.substr(0, rest.find(','));
      EXPECT_TRUE(words.insert(word).second && !word.empty()) << type->name;
      rest.erase(0, std::min(rest.size(), word.size() + 1));
    }
    if (type->data == DataType::kBoolean) {
      EXPECT_TRUE(words.empty() || words.size() == 2) << type->name;
    }
  }
}

TEST(TypeCatalogue, EachTableKeepsToItsRangeInRisingOrder) {
  const std::tuple<std::span<const Type>, unsigned, unsigned> tables[] = {{mote_types(), 0x0001, 0x007f},
                                                                          {register_types(), 0x0100, 0x01ff},
                                                                          {home_types(), 0x0200, 0x03ff},
                                                                          {quantity_types(), 0x0400, 0x05ff},
                                                                          {property_types(), 0x0600, 0x06ff}};
  for (const auto& [table, first, last] : tables) {
    unsigned before = first - 1;
    for (const auto& type : table) {
      const auto id = unsigned{static_cast<std::uint16_t>(type.id)};
      EXPECT_GT(id, before) << type.name;
      EXPECT_LE(id, last) << type.name;
      before = id;
    }
  }
}

TEST(TypeCatalogue, IdsThatPeersRememberStay) {
  EXPECT_EQ(type_of("light").id, TypeId{0x0001});
  EXPECT_EQ(type_of("temperature").id, TypeId{0x0002});
  EXPECT_EQ(type_of("unsigned8BitOutput").id, TypeId{0x0145});
  EXPECT_EQ(type_of("switch").id, TypeId{0x0200});
  EXPECT_EQ(type_of("motion").id, TypeId{0x000a});
  EXPECT_EQ(type_of("luminance").id, TypeId{0x0401});
  EXPECT_EQ(type_of("rate").id, TypeId{0x0600});
}

TEST(TypeCatalogue, PropertiesOfDeviceTypesAreTypes) {
  const TypeCatalogue types;
  std::set<std::uint16_t> ids;
  std::set<std::string_view> names;
  ASSERT_FALSE(TypeCatalogue::device_types().empty());
  for (const auto& device : TypeCatalogue::device_types()) {
    EXPECT_TRUE(ids.insert(device.id).second && names.insert(device.name).second) << device.name;
    for (const auto& property : device.properties) {
      EXPECT_NE(types.find(property.property), nullptr) << property.property;
      EXPECT_TRUE(property.belongs_to.empty() || types.find(property.belongs_to)) << property.belongs_to;
    }
  }
}

TEST(TypeCatalogue, DoesNotKnowWhatIsNotThere) {
  const TypeCatalogue types;
  EXPECT_EQ(types.find(TypeId{0}), nullptr);
  EXPECT_EQ(types.find(TypeId{0x7fff}), nullptr);
  EXPECT_EQ(types.find("Temperature"), nullptr);
  EXPECT_EQ(types.find(""), nullptr);
}

TEST(TypeParse, ABooleanTakesItsWordsAndTheGeneralOnes) {
  for (const auto* text : {"on", "true", "1", "ON", "True"}) EXPECT_EQ(parsed("switch", text), Value(true)) << text;
  for (const auto* text : {"off", "false", "0"}) EXPECT_EQ(parsed("switch", text), Value(false)) << text;
  EXPECT_EQ(parsed("contact", "open"), Value(true));
  EXPECT_EQ(parsed("contact", "Closed"), Value(false));
  EXPECT_EQ(parsed("contact", "closed"), Value(false));
  EXPECT_EQ(parsed("contact", "on"), Value(true));
  EXPECT_EQ(parse_error("switch", "open"), (Error{ErrorCode::kInvalid, "switch: 'open' is not one of off, on"}));
  EXPECT_EQ(parse_error("contact", "ajar"),
            (Error{ErrorCode::kInvalid, "contact: 'ajar' is not one of closed,open (or off, on)"}));
  EXPECT_EQ(parse_error("switch", "onn").text, "switch: 'onn' is not one of off, on");
  EXPECT_EQ(parse_error("switch", "").text, "switch: '' is not one of off, on");
  EXPECT_EQ(parse_error("contact", "").code, ErrorCode::kInvalid);
}

TEST(TypeParse, AWholeNumberKeepsToItsRange) {
  EXPECT_EQ(parsed("unsigned8BitOutput", "0"), Value(std::int64_t{0}));
  EXPECT_EQ(parsed("unsigned8BitOutput", "255"), Value(std::int64_t{255}));
  EXPECT_EQ(parsed("unsigned8BitOutput", "+7"), Value(std::int64_t{7}));
  EXPECT_EQ(parse_error("unsigned8BitOutput", "256"),
            (Error{ErrorCode::kOutOfRange, "unsigned8BitOutput: '256' is not a number from 0 to 255"}));
  EXPECT_EQ(parse_error("unsigned8BitOutput", "-1").code, ErrorCode::kOutOfRange);
  for (const auto* text : {"", "1.5", "0x10", "1e2", " 1", "1 ", "+-1", "--1", "+", "seven", "99999999999999999999"}) {
    EXPECT_EQ(parse_error("unsigned8BitOutput", text),
              (Error{ErrorCode::kInvalid, "unsigned8BitOutput: '" + std::string(text) + "' is not a whole number"}));
  }
}

TEST(TypeParse, ANumberKeepsToItsRange) {
  EXPECT_EQ(parsed("temperature", "21.5"), Value(21.5));
  EXPECT_EQ(parsed("temperature", "-273.15"), Value(-273.15));
  EXPECT_EQ(parsed("temperature", "2e3"), Value(2000.0));
  EXPECT_EQ(parse_error("temperature", "-274"),
            (Error{ErrorCode::kOutOfRange, "temperature: '-274' is not a number from -273.15 to 2000 Cel"}));
  EXPECT_EQ(parse_error("luminance", "-1").text, "luminance: '-1' is not a number from 0 cd/m2");
  for (const auto* text : {"", "nan", "inf", "-inf", "0x10", "1e999", "21,5", "21.5 ", "+-1", "warm"}) {
    EXPECT_EQ(parse_error("temperature", text),
              (Error{ErrorCode::kInvalid, "temperature: '" + std::string(text) + "' is not a decimal number"}));
  }
}

TEST(TypeParse, AnEnumerationTakesWordsAndNumbers) {
  EXPECT_EQ(parsed("blindStep", "up"), Value(std::string("up")));
  EXPECT_EQ(parsed("blindStep", "1"), Value(std::string("down")));
  EXPECT_EQ(parsed("blindStep", "Up"), Value(std::string("up"))) << "case, blanks and hyphens do not count";
  for (const auto* text : {"", "2", "-1", "Upp", "up,down", "9223372036854775807", "-9223372036854775808"}) {
    EXPECT_EQ(parse_error("blindStep", text),
              (Error{ErrorCode::kInvalid, "blindStep: '" + std::string(text) + "' is not one of up,down"}));
  }
}

TEST(TypeParse, AnEnumerationWithoutWordsTakesThoseOfItsPointsAndNumbers) {
  EXPECT_EQ(parsed("enumerationOutput", "heat"), Value(std::string("heat")));
  EXPECT_EQ(parsed("enumerationOutput", "7"), Value(std::int64_t{7})) << "as older islands and recordings have it";
  EXPECT_EQ(parse_error("enumerationOutput", "65536").code, ErrorCode::kOutOfRange);
  EXPECT_EQ(parse_error("enumerationOutput", "").code, ErrorCode::kInvalid);
  const TypeCatalogue types;
  const auto& type = *types.find("enumerationInput");
  EXPECT_TRUE(TypeCatalogue::check(type, std::string("heat")));
  EXPECT_TRUE(TypeCatalogue::check(type, std::int64_t{7}));
  EXPECT_FALSE(TypeCatalogue::check(type, std::int64_t{-1}));
  EXPECT_FALSE(TypeCatalogue::check(type, true));
  EXPECT_EQ(parsed("bitsetInput", "16641"), Value(Json{"16641"})) << "as older recordings have it";
}

TEST(TypeParse, TextIsTakenAsItIs) {
  EXPECT_EQ(parsed("label", " any \n text"), Value(std::string(" any \n text")));
  EXPECT_EQ(parsed("label", ""), Value(std::string()));
  EXPECT_EQ(
      parse_error("label", std::string(65537, 'x')),
      (Error{ErrorCode::kOutOfRange, "label: '" + std::string(60, 'x') + "...' is not at most 65536 bytes long"}));
}

TEST(TypeParse, JsonMustBeJson) {
  EXPECT_EQ(parsed("record", R"({"x":1})"), Value(Json{R"({"x":1})"}));
  EXPECT_EQ(parse_error("record", "{x:1}"), (Error{ErrorCode::kInvalid, "record: '{x:1}' is not JSON"}));
  EXPECT_EQ(parse_error("record", "").text, "record: '' is not JSON");
  EXPECT_EQ(parse_error("record", std::string(65537, ' ')).code, ErrorCode::kOutOfRange);
  EXPECT_EQ(parse_error("record", std::string(60000, '[')).code, ErrorCode::kInvalid);
}

TEST(TypeParse, BytesAreHex) {
  EXPECT_EQ(parsed("bytesOutput", "00ff"), Value(std::string("00ff")));
  EXPECT_EQ(parse_error("bytesOutput", "0f0"), (Error{ErrorCode::kInvalid, "bytesOutput: '0f0' is not bytes in hex"}));
  EXPECT_EQ(parse_error("bytesOutput", "zz").text, "bytesOutput: 'zz' is not bytes in hex");
  EXPECT_EQ(parse_error("bytesOutput", std::string(65538, '0')).code, ErrorCode::kOutOfRange);
}

TEST(TypeCheck, TakesWhatFits) {
  const std::string fits = "accepted";
  EXPECT_EQ(check_error("temperature", 21.5).text, fits);
  EXPECT_EQ(check_error("temperature", std::int64_t{21}).text, fits);
  EXPECT_EQ(check_error("unsigned8BitInput", std::int64_t{255}).text, fits);
  EXPECT_EQ(check_error("contact", true).text, fits);
  EXPECT_EQ(check_error("button", std::string("long")).text, fits);
  EXPECT_EQ(check_error("label", std::string("x")).text, fits);
  EXPECT_EQ(check_error("record", Json{"{}"}).text, fits);
  EXPECT_EQ(check_error("bytesInput", std::string("00")).text, fits);
}

TEST(TypeCheck, RefusesTheWrongKindOfData) {
  const auto invalid = [](const char* text) { return Error{ErrorCode::kInvalid, text}; };
  EXPECT_EQ(check_error("temperature", std::string("x")), invalid("temperature: 'x' is not a number"));
  EXPECT_EQ(check_error("temperature", true), invalid("temperature: 'on' is not a number"));
  EXPECT_EQ(check_error("temperature", Value()), invalid("temperature: '' is not a number"));
  EXPECT_EQ(check_error("temperature", std::numeric_limits<double>::quiet_NaN()),
            invalid("temperature: '' is not a number"));
  EXPECT_EQ(check_error("temperature", std::numeric_limits<double>::infinity()).code, ErrorCode::kInvalid);
  EXPECT_EQ(check_error("unsigned8BitInput", 1.0), invalid("unsigned8BitInput: '1' is not a whole number"));
  EXPECT_EQ(check_error("switch", std::int64_t{1}), invalid("switch: '1' is not off or on"));
  EXPECT_EQ(check_error("blindStep", std::string()), invalid("blindStep: '' is not a word or a number"));
  EXPECT_EQ(check_error("blindStep", true).code, ErrorCode::kInvalid);
  EXPECT_EQ(check_error("record", std::string("{}")), invalid("record: '{}' is not JSON"));
  EXPECT_EQ(check_error("label", 1.5), invalid("label: '1.5' is not text"));
}

TEST(TypeCheck, AReadingOfAnEnumerationMayBeAnyWordOrNumber) {
  const TypeCatalogue types;
  const auto& step = *types.find("blindStep");
  for (const auto& value : {Value(std::string("up")), Value(std::string("left")), Value(std::int64_t{7})})
    EXPECT_TRUE(TypeCatalogue::check(step, value)) << to_text(value);
  EXPECT_EQ(*TypeCatalogue::parse_reading(step, "UP"), Value(std::string("up")));
  EXPECT_EQ(*TypeCatalogue::parse_reading(step, "left"), Value(std::string("left")));
  EXPECT_EQ(*TypeCatalogue::parse_reading(step, "7"), Value(std::int64_t{7}));
  EXPECT_FALSE(TypeCatalogue::parse_reading(step, ""));
  EXPECT_FALSE(TypeCatalogue::parse(step, "left")) << "but not what a user writes";
}

TEST(TypeCheck, RefusesWhatIsOutOfRange) {
  EXPECT_EQ(check_error("humidity", 100.5),
            (Error{ErrorCode::kOutOfRange, "humidity: '100.5' is not a number from 0 to 100 %"}));
  EXPECT_EQ(check_error("humidity", std::int64_t{-1}).code, ErrorCode::kOutOfRange);
  EXPECT_EQ(check_error("unsigned8BitInput", std::int64_t{256}).text,
            "unsigned8BitInput: '256' is not a number from 0 to 255");
}

TEST(SiteType, CanBeDeclaredFrom0x8000On) {
  TypeCatalogue types;
  auto wine = site_type(0x8000, "wineSugar");
  wine.unit = "g/L";
  wine.maximum = 300;
  ASSERT_TRUE(types.declare(wine));
  ASSERT_TRUE(types.declare(site_type(0xffff, "last_one")));
  const auto* found = types.find("wineSugar");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found, types.find(TypeId{0x8000}));
  EXPECT_EQ(found, types.all()[types.all().size() - 2]);
  EXPECT_EQ(found->unit, "g/L");
  EXPECT_FALSE(TypeCatalogue::parse(*found, "301"));
}

TEST(SiteType, StaysWhereItIsWhenMoreCome) {
  TypeCatalogue types;
  ASSERT_TRUE(types.declare(site_type(0x8000, "a")));
  const auto* first = types.find("a");
  for (int i = 1; i < 1000; ++i) {
    ASSERT_TRUE(types.declare(site_type(static_cast<std::uint16_t>(0x8000 + i), "a" + std::to_string(i))));
  }
  const TypeCatalogue moved = std::move(types);
  EXPECT_EQ(moved.find("a"), first);
  EXPECT_EQ(first->name, "a");
}

TEST(SiteType, CannotTakeAnIdOrANameThatIsThere) {
  TypeCatalogue types;
  EXPECT_EQ(types.declare(site_type(0x8000, "temperature")).error(),
            (Error{ErrorCode::kDuplicate, "type temperature: the name is taken by id 0x0002"}));
  ASSERT_TRUE(types.declare(site_type(0x8000, "mine")));
  EXPECT_EQ(types.declare(site_type(0x8001, "mine")).error(),
            (Error{ErrorCode::kDuplicate, "type mine: the name is taken by id 0x8000"}));
  EXPECT_EQ(types.declare(site_type(0x8000, "other")).error(),
            (Error{ErrorCode::kDuplicate, "type other: id 0x8000 is taken by mine"}));
  EXPECT_EQ(types.find("other"), nullptr);
}

TEST(SiteType, CannotTakeABuiltInId) {
  TypeCatalogue types;
  EXPECT_EQ(types.declare(site_type(0x7fff, "mine")).error(),
            (Error{ErrorCode::kOutOfRange, "type mine: id 0x7fff is not the site's own, expected 0x8000..0xffff"}));
  EXPECT_EQ(types.declare(site_type(2, "mine")).error().code, ErrorCode::kOutOfRange);
}

TEST(SiteType, NeedsAProperName) {
  TypeCatalogue types;
  for (const std::string name : {"", "9lives", "light-2", "a.b", "a b", "gr\xc3\xbcn", "_x"}) {
    const auto refused = types.declare(site_type(0x8000, name));
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid) << name;
  }
  EXPECT_EQ(types.declare(site_type(0x8000, "light-2")).error().text,
            "type name 'light-2': expected a letter, then at most 63 of [A-Za-z0-9_]");
  EXPECT_TRUE(types.declare(site_type(0x8000, std::string(64, 'a'))));
  EXPECT_FALSE(types.declare(site_type(0x8001, std::string(65, 'a'))));
}

TEST(SiteType, NeedsARangeThatHoldsSomething) {
  TypeCatalogue types;
  auto type = site_type(0x8000, "mine");
  type.minimum = 2;
  type.maximum = 1;
  EXPECT_EQ(types.declare(type).error(), (Error{ErrorCode::kInvalid, "type mine: the minimum is above the maximum"}));
  type.minimum = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(types.declare(type));
}

TEST(SiteType, AnEnumerationNeedsWords) {
  TypeCatalogue types;
  auto type = site_type(0x8000, "mine");
  type.data = DataType::kEnumeration;
  EXPECT_EQ(types.declare(type).error(), (Error{ErrorCode::kInvalid, "type mine: an enumeration needs its words"}));
  type.words = "red,green";
  ASSERT_TRUE(types.declare(type));
  EXPECT_EQ(*TypeCatalogue::parse(*types.find("mine"), "1"), Value(std::string("green")));
}

TEST(SiteType, KeepsItsOwnTextAlive) {
  TypeCatalogue types;
  {
    auto type = site_type(0x8000, std::string("aNameTooLongForTheSmallStringBuffer"));
    type.quantity = "a quantity too long for the small string buffer";
    ASSERT_TRUE(types.declare(type));
  }
  EXPECT_EQ(types.find(TypeId{0x8000})->name, "aNameTooLongForTheSmallStringBuffer");
  EXPECT_EQ(types.find(TypeId{0x8000})->quantity, "a quantity too long for the small string buffer");
}

TEST(TypeWords, AreTheSpellingOfTuples) {
  EXPECT_EQ(to_string(DataType::kBoolean), "boolean");
  EXPECT_EQ(to_string(DataType::kBytes), "bytes");
  EXPECT_EQ(to_string(Kind::kActuator), "actuator");
  EXPECT_EQ(to_string(Access::kReadWrite), "read-write");
}

}  // namespace
}  // namespace rubicon::model
