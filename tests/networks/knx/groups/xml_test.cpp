#include <fmt/format.h>

#include "networks/knx/groups/support.h"

namespace rubicon::networks::knx::groups {
namespace {

std::string document(std::string_view declaration, std::string_view body) {
  return fmt::format("{}<GroupAddress-Export xmlns=\"http://knx.org/xml/ga-export/01\">\n{}\n</GroupAddress-Export>\n",
                     declaration, body);
}

TEST(XmlList, RangesNameTheGroupsOfWhatIsInThem) {
  const auto list = read_group_list(document("", R"(<GroupRange Name="Light"><GroupRange Name="Hall">
<GroupAddress Name="Lamp" Address="1/0/1" Central="true" Unfiltered="true" DPTs="DPST-1-1" Description="a&#10;b"/>
</GroupRange><GroupAddress Name="Loose" Address="1/1/1" Security="On"/></GroupRange>
<GroupAddress Name="Alone" Address="2/0/1"/>)"));
  ASSERT_EQ(list.entries.size(), 3U) << texts(list.report);
  const auto& lamp = list.entries[0];
  EXPECT_EQ(lamp.main_group, "Light");
  EXPECT_EQ(lamp.middle_group, "Hall");
  EXPECT_EQ(lamp.description, "a\nb");
  EXPECT_EQ(lamp.dpt, dpt("1.001"));
  EXPECT_EQ(lamp.line, 3U);
  EXPECT_TRUE(lamp.central && lamp.unfiltered);
  EXPECT_EQ(list.entries[1].middle_group, "");
  EXPECT_EQ(list.entries[1].security, "On");
  EXPECT_EQ(list.entries[2].main_group, "");
}

TEST(XmlList, PrefixesOfTheNamespaceDoNotMatter) {
  const auto list = read_xml(
      "<k:GroupAddress-Export xmlns:k=\"http://knx.org/xml/ga-export/01\"><k:GroupAddress Name=\"Lamp\" "
      "Address=\"1/0/1\"/></k:GroupAddress-Export>");
  EXPECT_EQ(list.entries.size(), 1U) << texts(list.report);
}

struct Encoded {
  const char* declaration;
  const char* name;
  const char* as;
};

TEST(XmlList, DeclaredEncodingsAreRead) {
  for (const auto& [declaration, name, as] :
       {Encoded{"<?xml version=\"1.0\" encoding=\"windows-1252\"?>",
                "K\xfc"
                "che \x80",
                "Küche €"},
        Encoded{"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
                "K\xfc"
                "che",
                "Küche"},
        Encoded{"<?xml version=\"1.0\" encoding=\"utf-8\"?>", "Küche €", "Küche €"}, Encoded{"", "Küche", "Küche"},
        Encoded{"\xef\xbb\xbf<?xml version=\"1.0\"?>", "Küche", "Küche"}}) {
    const auto list =
        read_group_list(document(declaration, fmt::format("<GroupAddress Name=\"{}\" Address=\"1/0/1\"/>", name)));
    ASSERT_EQ(list.entries.size(), 1U) << declaration << texts(list.report);
    EXPECT_EQ(list.entries[0].name, as);
  }
}

TEST(XmlList, OtherEncodingsAndBytesOutsideTheirEncodingRefuseTheFile) {
  const auto unknown = read_xml(document("<?xml version=\"1.0\" encoding=\"koi8-r\"?>", ""));
  EXPECT_TRUE(unknown.report.refused);
  EXPECT_NE(texts(unknown.report).find("encoding is not known"), std::string::npos);
  const auto broken = read_xml(document("",
                                        "<GroupAddress Name=\"K\xfc"
                                        "che\" Address=\"1/0/1\"/>"));
  EXPECT_TRUE(broken.report.refused);
  EXPECT_NE(texts(broken.report).find("not well-formed"), std::string::npos);
}

TEST(XmlList, EntitiesAreNeverExpanded) {
  std::string bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE x [<!ENTITY a0 \"aaaaaaaaaa\">";
  for (int i = 1; i < 30; ++i) {
    bomb += fmt::format("<!ENTITY a{} \"&a{};&a{};&a{};&a{};\">", i, i - 1, i - 1, i - 1, i - 1);
  }
  bomb += "]>\n" + document("", "<GroupAddress Name=\"&a29;\" Address=\"1/0/1\"/>");
  for (const auto& text :
       {bomb, "<!DOCTYPE x SYSTEM \"file:///etc/passwd\">" + document("", ""), "<!DOCTYPE x>" + document("", "")}) {
    const auto list = read_group_list(text);
    EXPECT_TRUE(list.report.refused);
    EXPECT_TRUE(list.entries.empty());
    EXPECT_NE(texts(list.report).find("DOCTYPE not allowed"), std::string::npos);
  }
}

TEST(XmlList, ErrorsOfOneAddressDoNotAffectOthers) {
  const auto list = read_xml(document("", R"(<GroupAddress Name="Lamp" Address="1/0/1"/>
<GroupAddress Name="Twice" Address="1/0/1"/>
<GroupAddress Name="Far" Address="32/0/1"/>
<GroupAddress Name="None"/>
<Strange/>
<GroupAddress Name="Type" Address="1/0/2" DPTs="DPST-9-999"/>)"));
  EXPECT_EQ(list.entries.size(), 2U);
  EXPECT_EQ(list.report.errors, 3U) << texts(list.report);
  EXPECT_EQ(list.report.warnings, 2U) << texts(list.report);
  EXPECT_EQ(list.report.doubled, 1U);
}

TEST(XmlList, DeepNestingIsRefused) {
  std::string deep = "<GroupAddress-Export>";
  for (int i = 0; i < 100'000; ++i) deep += "<GroupRange Name=\"a\">";
  const auto list = read_xml(deep);
  EXPECT_TRUE(list.report.refused);
  EXPECT_NE(texts(list.report).find("elements nested 33 deep"), std::string::npos);
}

TEST(EsfList, FirstDotEndsTheMainGroupAndTheLastBeginsTheAddress) {
  const auto list = read_group_list(
      "House\r\nGround.floor.west.1/0/1\tLamp\tEIS 1 'Switching' (1 Bit)\tLow\t1/0/2 1/0/3\r\n"
      "Ground.Hall.1/0/2\tDim\tEIS 2 'Dimming - control' (4 Bit)\tLow\t\r\n");
  EXPECT_EQ(list.report.form, "ESF");
  ASSERT_EQ(list.entries.size(), 2U) << texts(list.report);
  EXPECT_EQ(list.entries[0].main_group, "Ground");
  EXPECT_EQ(list.entries[0].middle_group, "floor.west");
  EXPECT_EQ(list.entries[0].listen, (std::vector<wire::GroupAddress>{ga("1/0/2"), ga("1/0/3")}));
  EXPECT_EQ(list.entries[1].dpt, dpt("3.*"));
  EXPECT_EQ(list.report.warnings, 0U) << texts(list.report);
}

TEST(EsfList, EveryEisNumberGivesItsMainType) {
  const std::vector<unsigned> mains{1, 3, 10, 11, 9, 5, 1, 2, 14, 7, 12, 15, 4, 5, 16};
  std::string text = "House\n";
  for (std::size_t eis = 1; eis <= 15; ++eis)
    text += fmt::format("A.B.1/0/{}\tn\tEIS {} 'x' (1 Bit)\tLow\t\n", eis, eis);
  const auto list = read_esf(text);
  ASSERT_EQ(list.entries.size(), mains.size());
  for (std::size_t i = 0; i < mains.size(); ++i) {
    ASSERT_TRUE(list.entries[i].dpt);
    EXPECT_EQ(list.entries[i].dpt->main, mains[i]);
    EXPECT_EQ(list.entries[i].dpt->sub, dpt::DptId::kMainOnly);
  }
  EXPECT_EQ(list.report.warnings, 3U) << "the sign of 10, 11 and 14 is unknown";
}

TEST(EsfList, TwoLevelProjectsHaveMainGroupsOnly) {
  const auto list = read_group_list("House\nLight.1/519\tLamp\tEIS 1 'Switching' (1 Bit)\tLow\t\n");
  ASSERT_EQ(list.entries.size(), 1U) << texts(list.report);
  EXPECT_EQ(list.entries[0].notation, wire::Notation::kTwoLevel);
  EXPECT_EQ(list.entries[0].main_group, "Light");
  EXPECT_EQ(list.entries[0].middle_group, "");
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
