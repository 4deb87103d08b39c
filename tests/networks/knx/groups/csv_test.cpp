#include <fmt/format.h>

#include <fstream>

#include "networks/knx/groups/csv_layout.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/support.h"

namespace rubicon::networks::knx::groups {
namespace {

std::string line_of(const GroupEntry& entry) {
  return fmt::format("{} {} [{}|{}] {} {}{}{}", to_string(entry.address, entry.notation), entry.name, entry.main_group,
                     entry.middle_group, entry.dpt ? to_string(*entry.dpt) : "-", entry.description,
                     entry.central ? " central" : "", entry.unfiltered ? " unfiltered" : "");
}

std::vector<std::string> lines_of(const GroupList& list) {
  std::vector<std::string> lines;
  for (const auto& entry : list.entries) lines.push_back(line_of(entry));
  return lines;
}

const std::vector<std::string> kHall{"1/0/1 Lamp [Light|Hall] 1.001 over the door central",
                                     "1/0/2 Lamp status [Light|Hall] 1.011 ", "2/0/1 Cold [Heating|Cellar] 9.001 "};

struct Variant {
  const char* name;
  const char* form;
  std::string text;
};

std::string with(std::string text, char delimiter) {
  for (auto& c : text) {
    if (c == ';') c = delimiter;
  }
  return text;
}

const std::string kThreeOne =
    "\"Light\";\"\";\"\";\"1/-/-\";\"\";\"\";\"\";\"\";\"Auto\"\r\n"
    "\"\";\"Hall\";\"\";\"1/0/-\";\"\";\"\";\"\";\"\";\"Auto\"\r\n"
    "\"\";\"\";\"Lamp\";\"1/0/1\";\"True\";\"\";\"over the door\";\"DPST-1-1\";\"Auto\"\r\n"
    "\"\";\"\";\"Lamp status\";\"1/0/2\";\"\";\"\";\"\";\"DPST-1-11\";\"Auto\"\r\n"
    "\"Heating\";\"\";\"\";\"2/-/-\";\"\";\"\";\"\";\"\";\"Auto\"\r\n"
    "\"\";\"Cellar\";\"\";\"2/0/-\";\"\";\"\";\"\";\"\";\"Auto\"\r\n"
    "\"\";\"\";\"Cold\";\"2/0/1\";\"\";\"\";\"\";\"DPST-9-1\";\"Auto\"\r\n";
const std::string kOneOne =
    "Light;1/-/-;;;;;Auto\nHall;1/0/-;;;;;Auto\nLamp;1/0/1;True;;over the door;DPST-1-1;Auto\n"
    "Lamp status;1/0/2;;;;DPST-1-11;Auto\nHeating;2/-/-;;;;;Auto\nCellar;2/0/-;;;;;Auto\n"
    "Cold;2/0/1;;;;DPST-9-1;Auto\n";
const std::string kOneThree =
    "Light;1;;;;;;;Auto\nHall;1;0;;;;;;Auto\nLamp;1;0;1;True;;over the door;DPST-1-1;Auto\n"
    "Lamp status;1;0;2;;;;DPST-1-11;Auto\nHeating;2;;;;;;;Auto\nCellar;2;0;;;;;;Auto\nCold;2;0;1;;;;DPST-9-1;Auto\n";
const std::string kThreeThree =
    "Light;;;1;-;-;;;;;Auto\n;Hall;;1;0;-;;;;;Auto\n;;Lamp;1;0;1;True;;over the door;DPST-1-1;Auto\n"
    ";;Lamp status;1;0;2;;;;DPST-1-11;Auto\nHeating;;;2;-;-;;;;;Auto\n;Cellar;;2;0;-;;;;;Auto\n"
    ";;Cold;2;0;1;;;;DPST-9-1;Auto\n";
const std::string kTail = "Central;Unfiltered;Description;DatapointType;Security\n";

const std::vector<Variant> kVariants{
    {"three_one_bare", "ETS CSV 3/1", kThreeOne},
    {"three_one_header", "ETS CSV 3/1", "\"Main\";\"Middle\";\"Sub\";\"Address\";" + kTail + kThreeOne},
    {"three_one_tab", "ETS CSV 3/1", with("Main;Middle;Sub;Address;" + kTail + kThreeOne, '\t')},
    {"three_one_comma", "ETS CSV 3/1", with("Main;Middle;Sub;Address;" + kTail + kThreeOne, ',')},
    {"three_one_german", "ETS CSV 3/1",
     "Hauptgruppe;Mittelgruppe;Untergruppe;Adresse;Zentral;Ungefiltert;Beschreibung;Datenpunkttyp;Sicherheit\n" +
         kThreeOne},
    {"three_one_unknown_words", "ETS CSV 3/1",
     "Päärühm;Keskrühm;Alarühm;Aadress;Keskne;Filtrita;Kirjeldus;Tüüp;Turve\n" + kThreeOne},
    {"one_one_bare", "ETS CSV 1/1", kOneOne},
    {"one_one_header", "ETS CSV 1/1", "Group name;Address;" + kTail + kOneOne},
    {"one_one_tab", "ETS CSV 1/1", with("Group name;Address;" + kTail + kOneOne, '\t')},
    {"one_one_comma_bare", "ETS CSV 1/1", with(kOneOne, ',')},
    {"one_three_bare", "ETS CSV 1/3", kOneThree},
    {"one_three_header", "ETS CSV 1/3", "Group name;Main;Middle;Sub;" + kTail + kOneThree},
    {"three_three_bare", "ETS CSV 3/3", kThreeThree},
    {"three_three_header", "ETS CSV 3/3", "Main;Middle;Sub;Main;Middle;Sub;" + kTail + kThreeThree},
    {"three_three_tab", "ETS CSV 3/3", with("Main;Middle;Sub;Main;Middle;Sub;" + kTail + kThreeThree, '\t')},
    {"old_line_ends", "ETS CSV 1/1",
     [] {
       auto text = "Group name;Address;" + kTail + kOneOne;
       for (auto& c : text) c = c == '\n' ? '\r' : c;
       return text;
     }()},
};

class CsvVariants : public ::testing::TestWithParam<Variant> {};

TEST_P(CsvVariants, GiveTheSameAddresses) {
  const auto list = read_group_list(GetParam().text);
  EXPECT_EQ(list.report.form, GetParam().form);
  EXPECT_EQ(list.report.errors + list.report.warnings, 0U) << texts(list.report);
  EXPECT_EQ(lines_of(list), kHall);
}

INSTANTIATE_TEST_SUITE_P(All, CsvVariants, ::testing::ValuesIn(kVariants),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(CsvList, ANewerCommentColumnStandsBeforeTheType) {
  const auto list = read_csv(
      "Group name;Address;Central;Unfiltered;Description;Comment;DatapointType;Security\n"
      "Lamp;1/0/1;;True;first;second;DPST-1-1;On\nOther;1/0/2;;;;second;DPST-1-1;\n");
  ASSERT_EQ(list.entries.size(), 2U) << texts(list.report);
  EXPECT_EQ(list.entries[0].description, "first");
  EXPECT_EQ(list.entries[0].security, "On");
  EXPECT_TRUE(list.entries[0].unfiltered);
  EXPECT_EQ(list.entries[1].description, "second");
  EXPECT_EQ(list.entries[1].security, "Auto");
}

TEST(CsvList, TwoLevelsAndPlainNumbersAreNotationsToo) {
  const auto two = read_csv("Group name;Address;Central\nLight;1/-;\nLamp;1/519;\nBlind;1/520;\nWrong;1/0/1;\n");
  EXPECT_EQ(two.report.errors, 1U);
  ASSERT_EQ(two.entries.size(), 2U) << texts(two.report);
  EXPECT_EQ(line_of(two.entries[0]), "1/519 Lamp [Light|] - ");
  EXPECT_EQ(two.entries[0].address, ga("1/2/7"));
  const auto free = read_csv("Lamp;2567;;;;DPST-1-1;\nBlind;2568;;;;DPST-1-8;\n");
  ASSERT_EQ(free.entries.size(), 2U) << texts(free.report);
  EXPECT_EQ(line_of(free.entries[0]), "2567 Lamp [|] 1.001 ");
  const auto columns = read_csv("Lamp;1;519;;;x;DPST-1-1;\nBlind;1;520;;;y;DPST-1-8;\n");
  ASSERT_EQ(columns.entries.size(), 2U) << texts(columns.report);
  EXPECT_EQ(line_of(columns.entries[0]), "1/519 Lamp [|] 1.001 x");
}

TEST(CsvList, AGroupCalledCentralInTheFirstLineIsNoHeader) {
  const auto list = read_csv("Central;;;0/-/-;;;;;\n;;All;0/0/1;;;;DPST-1-1;\n");
  ASSERT_EQ(list.entries.size(), 1U);
  EXPECT_EQ(line_of(list.entries[0]), "0/0/1 All [Central|] 1.001 ");
}

TEST(CsvList, OfSeveralTypesTheFirstIsUsedWithAWarning) {
  const auto list = read_csv("Lamp;1/0/1;;;;DPST-1-1 DPST-1-2;\nBlind;1/0/2;;;;\"DPT-5, DPST-5-1\";\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[0].dpt, dpt("1.001"));
  EXPECT_EQ(list.entries[1].dpt, dpt("5.*"));
  EXPECT_EQ(list.report.warnings, 2U);
}

TEST(CsvList, AnAddressWithoutATypeIsANote) {
  const auto list = read_csv("Lamp;1/0/1;;;;;\nBlind;1/0/2;;;;DPT-5;\n");
  EXPECT_EQ(list.report.notes, 1U);
  EXPECT_EQ(list.report.untyped, 1U);
  EXPECT_EQ(list.report.main_type_only, 1U);
  EXPECT_EQ(list.report.warnings, 0U);
}

TEST(CsvList, AQuoteWithoutAnEndBreaksItsOwnLineOnly) {
  const auto list =
      read_csv("\"Lamp\";\"1/0/1\";\"\"\n\"Lost;1/0/2;\n\"Blind\";\"1/0/3\";\"\"\n\"Door\";\"1/0/4\";\"\"\n");
  EXPECT_EQ(list.entries.size(), 3U) << texts(list.report);
  const auto errors = findings(list.report, Finding::Level::kError);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].line, 2U);
}

TEST(CsvList, LinesAreCountedThroughFieldsWithLineBreaks) {
  const auto list = read_csv("\"A\nB\";\"1/0/1\";\"\"\n\n\"C\";\"1/0/2\";\"\"\nD;x;\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[0].name, "A\nB");
  EXPECT_EQ(list.entries[1].line, 4U);
  ASSERT_EQ(list.report.errors, 1U) << texts(list.report);
  EXPECT_EQ(findings(list.report, Finding::Level::kError)[0].line, 5U);
}

TEST(CsvList, AWindows1252FileNeedsNoWarnings) {
  const auto list = read_csv(
      "K\xfc"
      "che;1/0/1;\nGer\xe4t \x80;1/0/2;\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[0].name, "Küche");
  EXPECT_EQ(list.entries[1].name, "Gerät €");
  EXPECT_EQ(list.report.warnings, 0U);
}

TEST(CsvList, ALineThatIsNotUtf8InAFileThatIsIsAWarning) {
  const auto list = read_csv("Küche;1/0/1;\nGer\xe4t;1/0/2;\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[1].name, "Gerät");
  const auto warnings = findings(list.report, Finding::Level::kWarning);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].address, ga("1/0/2"));
}

TEST(CsvList, AFieldBeyond4KiBIsCutBetweenTwoCharacters) {
  std::string name = "x";
  while (name.size() < 5000) name += "ü";
  const auto list = read_csv(name + ";1/0/1;\nLamp;1/0/2;\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[0].name, name.substr(0, 4095));
  EXPECT_EQ(list.report.warnings, 1U);
}

TEST(CsvList, ControlCharactersAreRemovedFromNames) {
  const auto list = read_csv(std::string("La\x1b[31mmp\0!;1/0/1;\nLamp;1/0/2;\n", 32));
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.entries[0].name, "La [31mmp !");
}

TEST(CsvList, NamesThatLookLikeAddressesDoNotHideTheAddresses) {
  const auto list = read_csv("1/0/7;1/0/1;;\n1/0/8;1/0/2;;\n");
  ASSERT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(line_of(list.entries[0]), "1/0/1 1/0/7 [|] - ");
}

TEST(CsvList, TheSixtyFiveThousandFiveHundredAndThirtySixthAddressIsRefused) {
  std::string text = "Group name;Address;Central\n";
  for (int i = 1; i <= 65535; ++i) text += fmt::format("a{};{};\n", i, i);
  EXPECT_EQ(read_csv(text).report.errors, 0U);
  text += "twice;1;\n";
  const auto list = read_csv(text);
  EXPECT_EQ(list.entries.size(), 65535U);
  EXPECT_EQ(list.report.errors, 1U);
}

TEST(CsvList, AReportKeepsTenThousandLinesAndCountsTheRest) {
  std::string text = "Group name;Address;Central\nLamp;1/0/1;\n";
  for (int i = 0; i < 20'000; ++i) text += "Lamp;1/0/999;\n";
  const auto list = read_csv(text);
  EXPECT_EQ(findings(list.report, Finding::Level::kError).size(), kMaxFindings);
  EXPECT_EQ(list.report.errors, 20'000U);
  EXPECT_EQ(list.report.out_of_range, 20'000U);
  EXPECT_NE(texts(list.report).find("... and 10000 more"), std::string::npos);
}

TEST(CsvRecords, ManyQuotesWithoutAnEndEndTheFile) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += "\"lost;" + std::to_string(i) + "\nx\n";
  CsvRecords records(text, ';');
  std::size_t broken = 0;
  for (CsvRecord row; records.next(row);) broken += row.broken ? 1 : 0;
  EXPECT_TRUE(records.gave_up());
  EXPECT_EQ(broken, 1001U);
}

TEST(GroupLists, TextThatIsNoListIsRefused) {
  for (const std::string text : {"", "\n\n", "hello world\n", "name;type\nLamp;1.001\n", "PK\x03\x04zip",
                                 "<html><body/></html>", "<?xml version='1.0'?><a", "\xff\xfeL\0a\0"}) {
    const auto list = read_group_list(text);
    EXPECT_TRUE(list.report.refused) << text;
    EXPECT_EQ(list.report.errors, 1U) << text;
    EXPECT_TRUE(list.entries.empty()) << text;
  }
  EXPECT_TRUE(read_group_list(std::string(kMaxListBytes + 1, 'a')).report.refused);
}

/// ASCII and Latin-1 as UTF-16.
std::string wide(std::string_view latin, bool big, bool mark) {
  std::string out = mark ? (big ? "\xfe\xff" : "\xff\xfe") : "";
  for (const char c : latin) {
    if (big) out += '\0';
    out += c;
    if (!big) out += '\0';
  }
  return out;
}

TEST(CsvEncodings, Utf16IsReadInBothOrdersWithAndWithoutAMark) {
  const std::string text =
      "Group name\tAddress\tDatapointType\r\nLight\t1/-/-\t\r\nK\xfc"
      "che\t1/0/1\tDPST-1-1\r\n";
  for (const bool big : {false, true}) {
    for (const bool mark : {false, true}) {
      const auto list = read_group_list(wide(text, big, mark));
      ASSERT_EQ(list.entries.size(), 1U) << big << mark << texts(list.report);
      EXPECT_EQ(list.entries[0].name,
                "K\xc3\xbc"
                "che");
      EXPECT_EQ(list.entries[0].line, 3U);
      EXPECT_EQ(to_string(*list.entries[0].dpt), "1.001");
    }
  }
  for (const auto* name : {"utf16.csv", "utf16_no_mark.csv"}) {  // "Unicode text" of a spreadsheet
    std::ifstream file(std::string(RUBICON_SOURCE_DIR "/tests/cases/knx/") + name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto list = read_group_list(bytes);
    ASSERT_EQ(list.entries.size(), 1U) << name << texts(list.report);
    EXPECT_EQ(list.entries[0].name, "Küche Decke");
    EXPECT_EQ(list.report.errors, 0U);
  }
  const auto esf = wide("House\r\nA.B.1/0/1\tLamp\tEIS 1 'Switching' (1 Bit)\tLow\t\r\n", false, true);
  EXPECT_EQ(read_group_list(esf).report.form, "ESF");
}

TEST(CsvEncodings, PairsAndHalvesOfPairsInUtf16) {
  EXPECT_EQ(from_utf16(std::string_view("\x3d\xd8\xa1\xdc", 4), Wide::kLittle).value(), "\xf0\x9f\x92\xa1");
  EXPECT_EQ(from_utf16(std::string_view("\xd8\x3d\0a", 4), Wide::kBig).value(),
            "\xef\xbf\xbd"
            "a");
  EXPECT_EQ(from_utf16(std::string_view("a\0\x3d\xd8", 4), Wide::kLittle).value(), "a\xef\xbf\xbd");
}

TEST(CsvEncodings, WhatIsNoTextIsNamed) {
  using namespace std::string_view_literals;
  const auto why = [](std::string_view bytes) {
    const auto list = read_group_list(bytes);
    EXPECT_TRUE(list.report.refused);
    return list.report.findings.at(0).text;
  };
  EXPECT_EQ(why("\xff\xfe\0\0a\0\0\0"sv).substr(0, 14), "text in UTF-32");
  EXPECT_EQ(why("\xd0\xcf\x11\xe0more"sv).substr(0, 19), "a workbook of Excel");
  EXPECT_EQ(why("a;1/2/3\nb\0;1/2/4\n"sv).substr(0, 44), "byte 10 is zero, so this is no text, expecte");
  EXPECT_EQ(why(wide("a;1/2/3\n", false, true).substr(0, 15)), "UTF-16 with an odd number of bytes: the file is cut");
}

TEST(CsvList, AnAddressThatASpreadsheetMadeADateSaysSo) {
  const auto list =
      read_group_list("Light;1/-/-;\nLamp;1/0/1;\nLamp 2;01.02.2003;\nLamp 3;2003-02-01;\nLamp 4;lamp;\n");
  EXPECT_EQ(list.entries.size(), 1U);
  const auto errors = findings(list.report, Finding::Level::kError);
  ASSERT_EQ(errors.size(), 3U) << texts(list.report);
  EXPECT_NE(errors[0].text.find("looks like a date"), std::string::npos) << errors[0].text;
  EXPECT_NE(errors[1].text.find("looks like a date"), std::string::npos);
  EXPECT_EQ(errors[2].text.find("date"), std::string::npos) << errors[2].text;
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
