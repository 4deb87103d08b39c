#include <fmt/format.h>
#include <gtest/gtest.h>

#include "networks/knx/dpt/convert_line.h"
#include "networks/knx/dpt/samples.h"

// The worked values of knx.md 9.10 (measured with xknx and Calimero), and the tables of words and bits.

namespace rubicon::networks::knx::dpt {
namespace {

struct Worked {
  const char* type;
  const char* text;
  const char* hex;
};

constexpr Worked kWorked[] = {
    {"1.008", "down", "01"},
    {"2.001", "control, on", "03"},
    {"3.007", "increase 3", "0b"},
    {"3.008", "down 1", "09"},
    {"4.002", "ä", "e4"},
    {"5.001", "50", "80"},
    {"5.003", "90", "40"},
    {"6.001", "-5", "fb"},
    {"6.020", R"({"a":0,"b":1,"c":0,"d":1,"e":0,"mode":2})", "52"},  // one-hot: mode 1 of 0..2
    {"7.600", "2700", "0a8c"},
    {"8.010", "-1", "ff9c"},
    {"9.001", "21.5", "0c33"},
    {"9.001", "-5.3", "85ee"},
    {"9.001", "0.01", "0001"},
    {"9.001", "-0.01", "87ff"},
    {"9.004", "100", "1ce2"},
    {"9.001", "20.47", "07ff"},
    {"9.001", "20.48", "0c00"},
    {"9.001", "-20.48", "8000"},
    {"9.001", "-273", "a156"},
    {"9.002", "670433.28", "7ffe"},
    {"9.002", "-671088.64", "f800"},
    {"10.001", "Fri 13:30:15", "ad1e0f"},
    {"11.001", "2026-11-20", "140b1a"},
    {"11.001", "1999-12-31", "1f0c63"},
    {"13.001", "-1", "ffffffff"},
    {"14.056", "21.5", "41ac0000"},
    {"16.001", "Zürich", "5afc726963680000000000000000"},
    {"18.001", "learn 5", "85"},
    {"19.001", "2026-11-20T13:30:15", "7e0b14ad1e0f2080"},
    {"20.102", "comfort", "01"},
    {"20.105", "heat", "01"},
    {"22.101", R"x({"heating mode (0 cooling)":true,"overheat alarm":true,"fault":true})x", "4101"},
    {"28.001", "Zürich", "5ac3bc7269636800"},
    {"29.010", "1234567890123", "0000011f71fb04cb"},
    {"217.001", "1.2.3", "0883"},
    {"229.001", R"({"value":1234,"unit":"Wh"})", "0012d4500000"},
    {"229.001", R"({"value":21.5,"unit":"l/h"})", "000053fc3800"},
    {"232.600", "#ff8000", "ff8000"},
    {"235.001", R"({"energy":123456,"tariff":2})", "0001e2400200"},
    {"242.600", R"({"x":0.3127,"y":0.329,"brightness":78.43137254901961})", "500d5439c803"},
    {"242.600", R"({"x":0.3127,"y":0.329,"brightness":78})", "500d5439c703"},
    {"249.600", R"({"fade":2.5,"colourTemperature":2700,"brightness":50.19607843137255})", "00190a8c8007"},
    {"251.600", R"({"red":255,"green":128,"blue":0,"white":64})", "ff800040000f"},
    // Up 3, down 1, up 7.
    {"253.600", R"({"firstColour":25,"secondColour":-100,"brightness":1.5625})", "0b010f07"},
};

TEST(DptWorked, ValuesEncodeAsMeasured) {
  for (const auto& row : kWorked) {
    const auto& type = dpt(row.type);
    const auto sent = encode_text(type, row.text);
    ASSERT_TRUE(sent) << row.type << ' ' << row.text << ": " << sent.error().text;
    EXPECT_EQ(base::to_hex(sent->bytes), row.hex) << row.type << ' ' << row.text;
    EXPECT_EQ(sent->small, type.bits > 0 && type.bits <= 6);
    EXPECT_EQ(encode_line(std::string(row.type) + ' ' + row.text), row.hex);
  }
}

constexpr Worked kRead[] = {
    {"1.001", "on", "01"},
    {"1.008", "down", "01"},
    {"1.017", "on", "01"},
    {"3.007", "25", "0b"},
    {"3.007", "-0", "08"},
    {"3.008", R"({"direction":"down","code":1})", "09"},
    {"5.001", "50.19607843137255", "80"},
    {"9.001", "-272.96", "a156"},
    {"9.001", "999.68", "361a"},
    {"10.001", "Fri 13:30:15", "ad1e0f"},
    {"10.001", "13:30:15", "0d1e0f"},
    {"11.001", "1999-12-31", "1f0c63"},
    {"14.056", "20.48", "41a3d70a"},
    {"15.000",
     R"({"code":"123456","readError":false,"permission":true,"rightToLeft":false,"encrypted":false,"index":7})",
     "12345647"},
    {"16.001", "Zürich", "5afc726963680000000000000000"},
    {"16.000", R"("")", "0000000000000000000000000000"},
    {"17.001", "5", "c5"},
    {"18.001", R"({"learn":true,"scene":5})", "85"},
    {"19.001", "2026-11-20T13:30:15", "7e0b14ad1e0f2080"},
    {"19.001",
     R"({"dateTime":"2026-07-01T24:00:00","weekday":0,"workingDay":true,"workingDayValid":true,"summerTime":true,)"
     R"("externalSync":false})",
     "7e07011800004100"},
    {"20.102", "comfort", "01"},
    {"20.102", "reserved (7)", "07"},
    {"20.003", "not occupied", "02"},
    {"23.002", "alarm position up", "01"},
    {"26.001", R"({"active":false,"scene":3})", "43"},
    {"27.001", R"({"output1":true,"output2":false,"output16":true})", "80038001"},
    {"219.001",
     R"({"logNumber":9,"priority":"low","applicationArea":"lighting","errorClass":40,"errorCodeSupported":true,)"
     R"("textSupported":false,"timeStampSupported":false,"acknowledgeSupported":true,"locked":false,)"
     R"("notAcknowledged":false,"inAlarm":true})",
     "090214280901"},
    {"221.001", "00c5:01020304", "00c501020304"},
    {"222.100", R"({"comfort":21.5,"standby":null,"economy":0.0})", "0c337fff0000"},
    {"231.001", "de-CH", "64654348"},
    {"232.600", "#ff8000", "ff8000"},
    {"234.001", "de", "6465"},
    {"235.001", R"({"energy":123456,"tariff":2})", "0001e2400200"},
    {"235.001", R"({"tariff":2})", "000000000202"},
    {"241.800",
     R"({"height":100.0,"failure":false,"localOverride":false,"locked":false,"forced":false,"weatherAlarm":false,)"
     R"("slatsLimited":false,"heightLimited":false,"targetReached":true,"lowerPosition":false,"lowerEnd":true,)"
     R"("upperEnd":false})",
     "ff00400a"},
    {"251.600", R"({"red":255,"white":64,"whiteValid":false})", "ff0000400008"},
    {"255.001", R"({"longitude":8.55,"latitude":47.37})", "4108cccd423d7ae1"},
    {"285.001", "2001:db8::1", "20010db8000000000000000000000001"},
    {"229.001",
     R"({"value":1234.0,"unit":"Wh","code":0,"out of service":false,"fault":true,"overridden":false,)"
     R"("in alarm":false,"alarm not acknowledged":false})",
     "0012d4500002"},
    {"999.001", "error: data point type 999.001 is not known", "00"},
    {"20.999", "7", "07"},
    {"240.999", R"({"raw":"0a0b0c"})", "0a0b0c"},
};

TEST(DptWorked, PayloadsReadNaturally) {
  for (const auto& row : kRead) EXPECT_EQ(decode_line(std::string(row.type) + ' ' + row.hex), row.text) << row.type;
}

TEST(DptWorked, EveryEnumerationHasItsWords) {
  const auto rows = rows_of(shared_file("dpt-enums.tsv"));
  if (rows.empty()) GTEST_SKIP() << "no " << shared_file("dpt-enums.tsv");
  for (const auto& row : rows) {
    const auto& type = dpt(row[0]);
    const auto hex = fmt::format("{:02x}", std::stoi(row[1]));
    const auto value = decode(type, payload(type, hex));
    ASSERT_TRUE(value) << row[0];
    EXPECT_EQ(model::to_text(*value), row[1]);
    EXPECT_EQ(label(type, *value), row[2]);
    EXPECT_EQ(decode_line(row[0] + ' ' + encode_line(row[0] + ' ' + row[2])), row[2]);
    if (row[0] == "20.610" && row[1] == "255") continue;  // the word of 3 too
    EXPECT_EQ(encode_line(row[0] + ' ' + row[2]), hex) << row[0] << ' ' << row[2];
    EXPECT_EQ(encode_line(row[0] + ' ' + row[1]), hex) << row[0] << ' ' << row[1];
    EXPECT_EQ(decode_line(row[0] + ' ' + hex), row[2]);
  }
}

TEST(DptWorked, EverySetHasItsBits) {
  const auto rows = rows_of(shared_file("dpt-bits.tsv"));
  if (rows.empty()) GTEST_SKIP() << "no " << shared_file("dpt-bits.tsv");
  for (const auto& row : rows) {
    const auto& type = dpt(row[0]);
    const auto raw = 1U << std::stoul(row[1]);
    const auto hex = fmt::format("{:0{}x}", raw, type.bits / 4);
    EXPECT_EQ(encode_line(row[0] + " {\"" + row[2] + "\":true}"), hex) << row[0] << ' ' << row[2];
    EXPECT_EQ(encode_line(row[0] + ' ' + std::to_string(raw)), hex);
    const auto text = decode_line(row[0] + ' ' + hex);
    EXPECT_NE(text.find('"' + row[2] + "\":true"), std::string::npos) << text;
    EXPECT_EQ(text.find(":true"), text.rfind(":true")) << text;
    EXPECT_TRUE(text.starts_with("{\"raw\":" + std::to_string(raw) + ',')) << text;
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::dpt
