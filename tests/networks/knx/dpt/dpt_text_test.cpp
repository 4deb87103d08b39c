#include <gtest/gtest.h>

#include <fstream>

#include "networks/knx/dpt/convert_line.h"
#include "networks/knx/dpt/samples.h"

namespace rubicon::networks::knx::dpt {
namespace {

std::string hex_of(std::string_view type, std::string_view text) {
  const auto sent = encode_text(dpt(type), text);
  return sent ? base::to_hex(sent->bytes) : std::string(base::to_string(sent.error().code));
}

TEST(DptText, OneBitTakesItsWordsAndTheUsualOnes) {
  for (const auto* text : {"down", "DOWN", "on", "true", "1", " Down "}) EXPECT_EQ(hex_of("1.008", text), "01") << text;
  for (const auto* text : {"up", "off", "False", "0"}) EXPECT_EQ(hex_of("1.008", text), "00") << text;
  for (const auto* text : {"", "2", "open", "01", "onn"}) EXPECT_EQ(hex_of("1.008", text), "invalid") << text;
  EXPECT_EQ(hex_of("1.017", "trigger"), "01");
  EXPECT_EQ(hex_of("1.999", "on"), "01");
}

TEST(DptText, NumbersMayHaveTheirUnit) {
  EXPECT_EQ(hex_of("9.001", "21.5 °C"), "0c33");
  EXPECT_EQ(hex_of("5.001", "50%"), "80");
  EXPECT_EQ(hex_of("5.001", "+50"), "80");
  for (const auto* text : {"", "nan", "inf", "-inf", "0x10", "1,5", "21.5 K", "on", "1e400", "--1", "+-1"}) {
    EXPECT_EQ(hex_of("9.001", text), "invalid") << text;
  }
  EXPECT_EQ(hex_of("9.001", "1e3"), "361b");
}

TEST(DptText, NothingIsClamped) {
  struct Bound {
    const char* type;
    const char* inside;
    const char* beyond;
  };
  constexpr Bound kBounds[] = {{"5.001", "0", "-0.001"},
                               {"5.001", "100", "100.001"},
                               {"5.003", "360", "360.001"},
                               {"5.004", "255", "255.5"},
                               {"5.004", "0", "-0.01"},
                               {"5.006", "254", "255"},
                               {"6.001", "-128", "-128.5"},
                               {"6.001", "127", "128"},
                               {"7.001", "65535", "65536"},
                               {"7.003", "655350", "655351"},
                               {"7.004", "6553500", "6553501"},
                               {"8.001", "-32768", "-32769"},
                               {"8.003", "327670", "327671"},
                               {"8.010", "327.67", "327.68"},
                               {"8.010", "-327.68", "-327.69"},
                               {"9.001", "-273", "-273.01"},
                               {"9.001", "670433.28", "670433.29"},
                               {"9.002", "-671088.64", "-671088.65"},
                               {"9.008", "0", "-0.01"},
                               {"9.027", "-459.6", "-459.7"},
                               {"12.001", "4294967295", "4294967296"},
                               {"12.001", "0", "-1"},
                               {"13.001", "-2147483648", "-2147483649"},
                               {"14.000", "3.4028235e38", "3.5e38"},
                               {"17.001", "63", "64"},
                               {"20.102", "255", "256"},
                               {"23.001", "3", "4"},
                               {"29.010", "9223372036854775807", "9223372036854775808"},
                               {"29.010", "-9223372036854775808", "-9223372036854777000"},
                               {"21.001", "31", "32"},
                               {"21.001", "0", "-1"},
                               {"3.007", "-100", "-100.1"},
                               {"11.001", "2089-12-31", "2090-01-01"},
                               {"11.001", "1990-01-01", "1989-12-31"},
                               {"19.001", "1900-01-01T00:00:00", "1899-12-31T23:59:59"},
                               {"16.000", "fourteen chars", "fifteen charact"},
                               {"25.1000", R"({"busy":3,"nak":0})", R"({"busy":4,"nak":0})"},
                               {"225.003", R"({"delay":65535,"tariff":254})", R"({"delay":65535,"tariff":255})"},
                               {"251.600", R"({"red":255})", R"({"red":256})"},
                               {"213.100", R"({"comfort":-272,"standby":0,"economy":0,"protection":655.34})",
                                R"({"comfort":-272.02,"standby":0,"economy":0,"protection":655.34})"}};
  for (const auto& bound : kBounds) {
    const auto inside = encode_text(dpt(bound.type), bound.inside);
    EXPECT_TRUE(inside) << bound.type << ' ' << bound.inside << ": " << inside.error().text;
    EXPECT_EQ(hex_of(bound.type, bound.beyond), "out-of-range") << bound.type << ' ' << bound.beyond;
  }
}

TEST(DptText, AValueThatWasNeverValidIsNotRead) {
  EXPECT_EQ(decode_line("9.001 7fff"), "error: 9.001 temperature: 7fff means no valid value");
  EXPECT_TRUE(decode_line("9.001 f800").starts_with("error: "));  // below absolute zero
  EXPECT_TRUE(decode_line("5.006 ff").starts_with("error: "));
  EXPECT_TRUE(decode_line("10.001 183c00").starts_with("error: "));
  EXPECT_TRUE(decode_line("11.001 1e021a").starts_with("error: "));  // 30 February
  EXPECT_TRUE(decode_line("14.000 7f800000").starts_with("error: "));
  EXPECT_TRUE(decode_line("14.000 7fc00000").starts_with("error: "));
  EXPECT_TRUE(decode_line("28.001 c328").starts_with("error: "));
}

TEST(DptText, AKindOfValueTheTypeDoesNotTakeIsRefused) {
  for (const auto& type : all_dpts()) {
    const bool takes_text = type.form == Form::kCharacter || type.form == Form::kText || type.form == Form::kLongText;
    for (const auto& value :
         {Value(), Value(std::string("no such thing at all")), Value(Json{"["}), Value(Json{"{}"})}) {
      if (takes_text && std::holds_alternative<std::string>(value)) continue;
      const auto sent = encode(type, value);
      // Sets and records whose fields may all be missing take the empty object.
      if (sent && std::holds_alternative<Json>(value)) continue;
      EXPECT_FALSE(sent) << to_string(type.id);
    }
    if (type.form != Form::kBit) {
      EXPECT_FALSE(encode(type, true)) << to_string(type.id);
    }
  }
  EXPECT_FALSE(encode(dpt("1.001"), std::int64_t{1}));
}

TEST(DptText, EnumerationsForgiveCaseBlanksAndHyphens) {
  for (const auto* text : {"building protection", "Building Protection", "building-protection", "4"}) {
    EXPECT_EQ(hex_of("20.102", text), "04") << text;
  }
  EXPECT_EQ(hex_of("20.102", "reserved (77)"), "4d");
  EXPECT_EQ(hex_of("20.013", "15 min"), "11");
  EXPECT_EQ(hex_of("20.013", "1.5 min"), "0c");
  EXPECT_EQ(hex_of("20.102", "cosy"), "invalid");
  EXPECT_EQ(hex_of("20.102", ""), "invalid");
}

TEST(DptText, TextKeepsToItsCodePage) {
  EXPECT_EQ(hex_of("16.001", "Zürich"), "5afc726963680000000000000000");
  EXPECT_EQ(hex_of("24.001", "Zürich"), "5afc7269636800");
  // Another text than the one that was asked for would stand on the display.
  EXPECT_EQ(hex_of("16.000", "Zürich"), "invalid");
  EXPECT_EQ(hex_of("16.001", "5 €"), "invalid");
  EXPECT_EQ(hex_of("16.001", "a\xff"), "invalid");
  EXPECT_EQ(hex_of("24.001", "š"), "invalid");
  EXPECT_EQ(encode_text(dpt("16.000"), "21 °C").error().text,
            "16.000 text, 14 characters ASCII: '21 °C' is not text in ASCII");
  EXPECT_EQ(hex_of("28.001", ""), "00");
  EXPECT_EQ(hex_of("28.001", "\xc3"), "invalid");
  EXPECT_EQ(hex_of("28.001", std::string(253, 'a')).size(), 506U);
  EXPECT_EQ(hex_of("28.001", std::string(254, 'a')), "out-of-range");
  EXPECT_EQ(hex_of("16.001", std::string_view("a\0b", 3)), "invalid");
  EXPECT_EQ(hex_of("4.001", "ä"), "invalid");
  EXPECT_EQ(hex_of("4.002", "ä"), "e4");
  EXPECT_EQ(hex_of("4.001", "ab"), "out-of-range");
}

TEST(DptText, TimesAreReadAsTheyAreWritten) {
  EXPECT_EQ(hex_of("10.001", "13:30:15"), "0d1e0f");
  EXPECT_EQ(hex_of("10.001", "fri 13:30"), "ad1e00");
  EXPECT_EQ(hex_of("19.001", "2026-11-20 13:30:15"), "7e0b14ad1e0f2080");
  EXPECT_EQ(hex_of("19.001", R"({"dateTime":"2026-07-01T12:00:00","summerTime":true})"), "7e07016c00002180");
  for (const auto* text : {"24:00:00", "23:60:00", "Fre 10:00:00", "10", "1:00:00", "10:00:0x"}) {
    EXPECT_EQ(hex_of("10.001", text), "invalid") << text;
  }
  for (const auto* text : {"2026-02-30", "20.11.2026", "2026-11-2", "2026-13-01", "2026-00-10"}) {
    EXPECT_EQ(hex_of("11.001", text), "invalid") << text;
  }
  for (const auto* text : {"2026-11-20", "2026-11-20T24:00:01", "{}", "{\"year\":2026}", "[1]",
                           R"({"dateTime":"2026-11-20T13:30:15","weekday":8})"}) {
    EXPECT_EQ(hex_of("19.001", text), "invalid") << text;
  }
  EXPECT_EQ(hex_of("19.001", "2026-11-20T24:00:00"), "7e0b14b800002080");
}

TEST(DptText, AClockThatDoesNotKnowTheDateIsStillRead) {
  const auto text = decode_line("19.001 0000000d1e0f3c00");
  EXPECT_EQ(text, R"({"year":1900,"month":0,"day":0,"hour":13,"minute":30,"second":15,"weekday":0,"yearValid":false,)"
                  R"("dateValid":false,"weekdayValid":false,"externalSync":false})");
  EXPECT_EQ(encode_line("19.001 " + text), "0000000d1e0f3c00");
  EXPECT_TRUE(decode_line("19.001 0000000d1e0f2000").starts_with("error: "));
}

/// Texts of devices in ISO 8859-1, what cannot be sent whole, words of manufacturers, records in part.
TEST(DptText, FollowsTheCases) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/knx/values.tsv");
  std::size_t rows = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    const auto first = line.find('\t'), second = line.find('\t', first + 1);
    ASSERT_NE(second, line.npos) << line;
    const auto asked = line.substr(first + 1, second - first - 1);
    EXPECT_EQ(line.starts_with("decode") ? decode_line(asked) : encode_line(asked), line.substr(second + 1)) << line;
    ++rows;
  }
  EXPECT_GE(rows, 10U);
}

TEST(DptText, RecordsNameTheFieldThatIsWrong) {
  const auto why = [](std::string_view type, std::string_view text) {
    const auto sent = encode_text(dpt(type), text);
    return sent ? std::string() : sent.error().text;
  };
  EXPECT_EQ(why("240.800", R"({"hieght":50})"), "240.800 blind height + slat position: unknown field 'hieght'");
  EXPECT_EQ(why("242.600", R"({"x":0.3})"), "242.600 colour xyY: y: expected a value, but it is missing");
  EXPECT_EQ(why("254.600", R"({"red":0,"green":0})"),
            "254.600 relative control RGB: blue: expected a value, but it is missing");
  EXPECT_EQ(why("217.001", "1.2"), "217.001 DPT version: '1.2' is not a JSON object");
  EXPECT_NE(why("206.100", R"({"delay":5,"mode":"cosy"})").find("mode: expected one of undefined, comfort"),
            std::string::npos);
  EXPECT_NE(why("27.001", R"({"output1":1})").find("output1: expected true or false"), std::string::npos);
  EXPECT_NE(why("25.1000", R"({"busy":1.5,"nak":0})").find("busy: expected a whole number"), std::string::npos);
  EXPECT_NE(why("251.600", R"({"redValid":true})").find("red: expected a value"), std::string::npos);
  EXPECT_NE(why("229.001", R"({"value":1,"unit":"parsec"})").find("unit"), std::string::npos);
  EXPECT_EQ(why("255.001", "{" + std::string(5000, ' ') + "}").substr(0, 8), "255.001 ");
  EXPECT_EQ(why("255.001", std::string(4000, '[')).substr(0, 8), "255.001 ");
}

TEST(DptText, ASetpointThatIsNotNamedIsNotUsed) {
  const auto sent = [](const char* type, const char* text) {
    const auto payload = encode_text(dpt(type), text);
    return payload ? base::to_hex(payload->bytes) : payload.error().text;
  };
  EXPECT_EQ(sent("222.101", R"({"economy":-1})"), "7fff7fff879c");
}

TEST(DptText, LabelsHelpPeople) {
  EXPECT_EQ(label(dpt("1.009"), true), "close");
  EXPECT_EQ(label(dpt("17.001"), std::int64_t{5}), "scene 6");
  EXPECT_EQ(label(dpt("3.007"), 12.5), "increase 12.5 %");
  EXPECT_EQ(label(dpt("3.007"), -0.0), "stop");
  EXPECT_EQ(label(dpt("20.102"), std::int64_t{7}), "reserved (7)");
  EXPECT_EQ(label(dpt("9.001"), 21.5), "21.5");
}

TEST(DptText, BrokenLinesAreAnsweredWithTheReason) {
  for (const auto* line : {"", " ", "9.001", "9.001 ", "9.001 0c", "9.001 0c3", "9.001 xx", "x 01", "1.001 0100",
                           "9.001 0c33 00", "12", "300.001 00"}) {
    EXPECT_TRUE(decode_line(line).starts_with("error: ")) << line;
  }
  for (const auto* line : {"", "9.001", "9.001 x", "x 1", "300.001 5"}) {
    EXPECT_TRUE(encode_line(line).starts_with("error: ")) << line;
  }
  EXPECT_EQ(decode_line(" 9.001  0C 33\r"), "21.5");
  EXPECT_EQ(encode_line("DPST-9-1 21.5\n"), "0c33");
  EXPECT_EQ(decode_line("16.001 0a220000000000000000000000"
                        "00"),
            R"("\n\"")");
  EXPECT_EQ(encode_line(R"(16.001 "\n\"")"),
            "0a2200000000000000000000"
            "0000");
}

TEST(DptText, CatalogueUnitsAndWordsAreThoseOfTheCatalogue) {
  const auto there = [](std::string_view type, const Value& value) {
    const auto result = to_catalogue(dpt(type), Kind::kSensor, value);
    return result ? model::to_text(*result) : result.error().text;
  };
  EXPECT_EQ(there("7.002", std::int64_t{1500}), "1.5");
  EXPECT_EQ(there("7.007", std::int64_t{2}), "7200");
  EXPECT_EQ(there("7.011", std::int64_t{1234}), "1.234");
  EXPECT_EQ(there("9.024", 0.07), "70");
  EXPECT_EQ(there("9.027", 70.7), "21.5");
  EXPECT_EQ(there("9.028", 36.0), "10");
  EXPECT_EQ(there("13.010", std::int64_t{1234}), "1.234");
  EXPECT_EQ(there("13.016", std::int64_t{2}), "2000");
  EXPECT_EQ(there("14.1201", 1.0), "3.6");
  EXPECT_EQ(there("14.056", 20.479999542236328), "20.48");
  EXPECT_EQ(there("29.010", std::int64_t{1234567890123}), "1234567890.123");
  EXPECT_EQ(there("20.102", std::int64_t{4}), "protection");
  EXPECT_EQ(there("20.102", std::int64_t{7}), "7") << "a vendor's";
  EXPECT_EQ(there("20.105", std::int64_t{1}), "heat");
  EXPECT_EQ(there("20.105", std::int64_t{18}), "18") << "a number that has no word";
  EXPECT_EQ(there("20.999", std::int64_t{3}), "3") << "nothing is known but the main type";
  EXPECT_EQ(there("21.001", Json{R"({"raw":3})"}), R"({"raw":3})");
  EXPECT_EQ(there("232.600", std::string("#ff8000")), "#ff8000");
  const auto sent = [](std::string_view type, const Value& value) {
    const auto& row = dpt(type);
    return base::to_hex(encode(row, *from_catalogue(row, Kind::kActuator, value))->bytes);
  };
  EXPECT_EQ(sent("7.002", 1.005), "03ed");
  EXPECT_EQ(sent("9.027", 21.5), "16e8");
  EXPECT_EQ(sent("20.102", std::string("protection")), "04");
  EXPECT_EQ(sent("20.105", std::string("heat")), "01");
  EXPECT_EQ(sent("20.105", std::int64_t{18}), "12");
  EXPECT_EQ(sent("21.001", std::int64_t{3}), "03") << "of a peer that knows no words";
  EXPECT_EQ(sent("21.001", Json{"3"}), "03");
  EXPECT_EQ(sent("21.001", Json{R"(["fault"])"}), "02");
  EXPECT_FALSE(from_catalogue(dpt("20.102"), Kind::kActuator, std::string("cosy")));
  EXPECT_FALSE(from_catalogue(dpt("17.001"), Kind::kActuator, std::int64_t{64}));
}

TEST(DptText, SetsOfBitsAreWrittenByNameInAnyForm) {
  for (const auto* text :
       {R"({"fault":true,"in alarm":true})", R"(["fault","in alarm"])", R"(["Fault","in-alarm"])", "10"}) {
    EXPECT_EQ(hex_of("21.001", text), "0a") << text;
  }
  EXPECT_EQ(hex_of("21.001", "in alarm"), "08");
  EXPECT_EQ(encode_line("21.001 folt").substr(0, 50), "error: 21.001 general status: 'folt' is not one of");
  EXPECT_EQ(decode_line("22.101 4101").substr(0, 27), R"({"raw":16641,"fault":true,")");
}

TEST(DptText, WordsOfTheCatalogueAreTakenToo) {
  EXPECT_EQ(hex_of("20.102", "protection"), "04");
  EXPECT_EQ(hex_of("1.009", "closed"), "01");
  EXPECT_EQ(hex_of("1.009", "close"), "01");
}

TEST(DptText, SinglesAreShownAsShortAsTheyReadBack) {
  EXPECT_EQ(decode_line("14.068 41c26666"), "24.3");
  EXPECT_EQ(decode_line("14.* 41c26666"), "24.3");
  EXPECT_EQ(natural(dpt("14.068"), 24.299999237060547), 24.3);
  EXPECT_EQ(natural(dpt("9.001"), 24.3), 24.3);
  EXPECT_EQ(natural(dpt("5.001"), 50.19607843137255), 50);
}

TEST(DptText, AnOpenTextOfFullLengthIsSentAgain) {
  const std::string full(253, 'g');
  const auto& type = *find_dpt({24, DptId::kMainOnly});
  const auto value = decode(type, wire::PayloadView{base::as_bytes(full), false});
  ASSERT_TRUE(value) << value.error().text;
  const auto sent = encode(type, *value);
  ASSERT_TRUE(sent) << sent.error().text;
  EXPECT_EQ(decode(type, *sent).value(), *value);
  EXPECT_FALSE(decode(type, wire::PayloadView{base::as_bytes(full + 'g'), false})) << "no telegram is so long";
  EXPECT_FALSE(encode(type, full + 'g'));
  EXPECT_LE(encode(type, full.substr(1))->bytes.size(), 253U);
}

}  // namespace
}  // namespace rubicon::networks::knx::dpt
