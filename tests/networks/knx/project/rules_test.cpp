#include "networks/knx/project/installation_document.h"
#include "networks/knx/project/programs.h"
#include "networks/knx/project/support.h"
#include "networks/knx/project/types.h"
#include "networks/knx/project/usage.h"

namespace rubicon::networks::knx::project {
namespace {

using groups::dpt;
using groups::Use;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<dpt::DptId> types(std::initializer_list<std::string_view> texts) {
  std::vector<dpt::DptId> out;
  for (const auto text : texts) out.push_back(dpt(text));
  return out;
}

// knx.md, section 21.9.
TEST(ProjectTypes, OfAnObjectAllCountAndItsSizeIfThereIsNone) {
  EXPECT_EQ(object_types("DPST-9-1", "2 Bytes"), types({"9.001"}));
  EXPECT_EQ(object_types("DPT-9 DPST-9-1  DPST-9-1", ""), types({"9.*", "9.001"}));
  EXPECT_EQ(object_types("", "1 Bit"), types({"1.*"}));
  EXPECT_EQ(object_types("", "2 Bit"), types({"2.*"}));
  EXPECT_EQ(object_types("", "4 Bit"), types({"3.*"}));
  EXPECT_TRUE(object_types("", "2 Bytes").empty());
  EXPECT_TRUE(object_types("", "14 Bytes").empty());
  EXPECT_EQ(object_types("DPST-5-250", "1 Byte"), types({"5.*"})) << "unknown sub type";
  EXPECT_EQ(object_types("DPT-999 nonsense", "1 Bit"), types({"1.*"})) << "unknown main type";
}

TEST(ProjectTypes, AreBounded) {
  std::string all;
  for (int sub = 1; sub < 500; ++sub) all += "DPST-20-" + std::to_string(sub) + " DPST-1-" + std::to_string(sub) + " ";
  EXPECT_LE(object_types(all, "").size(), kMaxTypes);
}

struct Rule {
  const char* own;
  std::vector<dpt::DptId> objects;
  const char* type;
  bool warns;
};

// knx.md, section 13.4.
TEST(ProjectTypes, OfAnAddressAreItsOwnOrThoseOfItsObjects) {
  for (const auto& [own, objects, type, warns] :
       {Rule{"9.001", types({"1.001"}), "9.001", false}, Rule{"", {}, "", false}, Rule{"9.*", {}, "9.*", false},
        Rule{"", types({"9.001", "9.001"}), "9.001", false}, Rule{"", types({"9.001", "9.002"}), "9.*", true},
        Rule{"", types({"1.*", "1.001"}), "1.*", true}, Rule{"", types({"1.001", "9.001"}), "", true},
        Rule{"9.*", types({"9.001", "9.001"}), "9.001", false}, Rule{"9.*", types({"9.001", "9.002"}), "9.*", false},
        Rule{"9.*", types({"1.001"}), "9.*", false}, Rule{"9.*", types({"1.001", "9.004"}), "9.004", false}}) {
    const auto chosen = type_of(*own == '\0' ? std::nullopt : std::optional(dpt(own)), objects);
    EXPECT_EQ(chosen.type ? to_string(*chosen.type) : "", type) << own;
    EXPECT_EQ(!chosen.change.empty(), warns) << own << " " << chosen.change;
  }
}

TEST(ProjectTexts, PlacesAreFilledFromParametersArgumentsAndDefaults) {
  const std::vector<std::pair<std::string, std::string>> arguments{{"Number", "3"}};
  EXPECT_EQ(filled_text("RTC {{Number}} ({{0:...}}) - Out", "bath", arguments, false), "RTC 3 (bath) - Out");
  EXPECT_EQ(filled_text("RTC {{Number}} ({{0:...}})", "", arguments, false), "RTC 3 (...)");
  EXPECT_EQ(filled_text("RTC {{Number}} ({{0:...}})", "", arguments, true), "RTC 3 ({{0:...}})");
  EXPECT_EQ(filled_text("{{0}}|{{Unknown}}|{{1:x}}", "", {}, false), "||x");
  EXPECT_EQ(filled_text("{{open", "p", {}, false), "{{open");
  EXPECT_EQ(filled_text("}}{{0}}", "p", {}, false), "}}p");
}

TEST(ProjectIds, LoseWhatAllOfAnInstallationShare) {
  EXPECT_EQ(short_id("P-0242-0_GA-6"), "GA-6");
  EXPECT_EQ(short_id("GA-6"), "GA-6");
  EXPECT_EQ(short_id("P-0242"), "P-0242");
}

/// Four addresses of type 1.001: indices 0 to 3.
std::vector<groups::GroupEntry> addresses(std::string_view type = "1.001") {
  std::vector<groups::GroupEntry> entries(4);
  for (auto& entry : entries) entry.dpt = dpt(type);
  return entries;
}

BusObject object(std::string_view flags, std::vector<std::size_t> links, const std::string& function = "",
                 std::size_t device = 0, const std::string& channel = "A") {
  const auto has = [&](char flag) { return flags.find(flag) != flags.npos; };
  return {device, channel, groups::words_of(function), {}, has('C'), has('R'), has('W'), has('T'), std::move(links)};
}

TEST(ProjectUsage, FlagsSayWhoTakesAndWhoReports) {
  const auto usage =
      usage_of({object("CW", {0}), object("CRT", {1}), object("CT", {2, 0}), object("CWT", {3})}, addresses(), {});
  EXPECT_THAT(usage.uses, ElementsAre(Use::kCommanded, Use::kReported, Use::kReported, Use::kCommanded))
      << "an object sends to its first address only";
  const auto shared =
      usage_of({object("CRT", {0}, "", 0), object("CW", {0}, "", 1), object("RWT", {1})}, addresses(), {});
  EXPECT_THAT(shared.uses, ElementsAre(Use::kShared, Use::kUnknown, Use::kUnknown, Use::kUnknown))
      << "without the flag of communication an object does nothing";
}

TEST(ProjectUsage, CommandAndStateOfOneChannelArePaired) {
  const auto usage = usage_of({object("CW", {0, 3}, "Switch"), object("CRT", {1}, "Status switch"),
                               object("CT", {0}, "Switching", 1), object("CWU", {1}, "LED", 1)},
                              addresses(), {});
  ASSERT_EQ(usage.states[0], 1U);
  EXPECT_FALSE(usage.states[3]) << "a central address has no state";
  EXPECT_EQ(usage.uses[0], Use::kCommanded) << "although a button sends to it";
  EXPECT_EQ(usage.uses[1], Use::kReported) << "although the button takes it for its light";
}

TEST(ProjectUsage, OtherChannelsDevicesTextsTypesAndDoubtsAreNoPairs) {
  auto entries = addresses();
  entries[1].dpt = dpt("5.001");
  EXPECT_FALSE(usage_of({object("CW", {0}, "Switch"), object("CRT", {1}, "Status switch")}, entries, {}).states[0]);
  for (const auto& other :
       {object("CRT", {1}, "Status switch", 1), object("CRT", {1}, "Status switch", 0, "B"),
        object("CRT", {1}, "Fault"), object("CRWT", {1}, "Status switch"), object("RT", {1}, "Status switch")})
    EXPECT_FALSE(usage_of({object("CW", {0}, "Switch"), other}, addresses(), {}).states[0]);
  EXPECT_FALSE(usage_of({object("CW", {0}, "Switch"), object("CRT", {1}, "Status switch"),
                         object("CRT", {2}, "Switch feedback")},
                        addresses(), {})
                   .states[0])
      << "two reports fit";
  EXPECT_FALSE(
      usage_of({object("CW", {0}, "Switch", 0, ""), object("CRT", {1}, "Status switch", 0, "")}, addresses(), {})
          .states[0])
      << "the channel is unknown";
  const auto twice = usage_of({object("CW", {0}, "Switch"), object("CRT", {1}, "Status switch"),
                               object("CW", {2}, "Switch", 1), object("CRT", {1}, "Status switch", 1)},
                              addresses(), {});
  EXPECT_FALSE(twice.states[0] || twice.states[2]) << "one address is the state of two";
}

TEST(ProjectUsage, MeasuredTemperaturesAreNoStateOfASetpoint) {
  const std::vector objects{object("CW", {0}, "Setpoint temperature"), object("CRT", {1}, "Actual temperature")};
  EXPECT_FALSE(usage_of(objects, addresses("9.001"), {}).states[0]);
  EXPECT_EQ(usage_of(objects, addresses("5.001"), {}).states[0], 1U);
}

TEST(ProjectUsage, RolesOfFunctionsGoBeforeFlags) {
  const auto usage = usage_of({object("CW", {0}, "Switch"), object("CRT", {1}, "Status switch")}, addresses(),
                              {{{0, "SwitchOnOff"}, {2, "InfoOnOff"}, {3, "CurrentAbsolutePosition"}}});
  EXPECT_EQ(usage.states[0], 2U);
  EXPECT_EQ(usage.uses[2], Use::kReported);
  EXPECT_EQ(usage.uses[3], Use::kReported);
}

TEST(ProjectUsage, LargeChannelsAreNotCompared) {
  std::vector<BusObject> objects;
  for (int i = 0; i < 100'000; ++i) objects.push_back(object(i % 2 == 0 ? "CW" : "CRT", {0}, "Switch"));
  EXPECT_FALSE(usage_of(objects, addresses(), {}).states[0]);
}

TEST(ProjectDocuments, ModulesInModulesKeepTheirDefinitions) {
  InstallationDocument document;
  ASSERT_TRUE(document.read_text(
      "<KNX><Installation><Area Address='1'><Line Address='1'><DeviceInstance Address='2'>"
      "<ComObjectInstanceRef RefId='MD-1_M-2_MI-3_SM-4_M-5_MI-6_O-7_R-8' Links='GA-1'/>"
      "<ComObjectInstanceRef RefId='M-00FA_A-1_MD-1_M-2_MI-3_O-7_R-8' Links='GA-1'/>"
      "<ComObjectInstanceRef RefId='M-00FA_A-1_O-7_R-8' Links=' GA-1  GA-2 '/>"
      "<ComObjectInstanceRef RefId='O-9_R-9'/></DeviceInstance></Line></Area></Installation></KNX>"));
  const auto installations = document.take();
  ASSERT_EQ(installations.size(), 1U);
  const auto& objects = installations[0].devices.at(0).objects;
  ASSERT_EQ(objects.size(), 3U) << "an object without links is not kept";
  EXPECT_EQ(objects[0].id, "MD-1_SM-4_O-7_R-8");
  EXPECT_EQ(objects[1].id, "M-00FA_A-1_MD-1_O-7_R-8");
  EXPECT_EQ(objects[1].module, "MD-1_M-2_MI-3");
  EXPECT_EQ(objects[2].id, "M-00FA_A-1_O-7_R-8");
  EXPECT_EQ(objects[2].module, "");
  EXPECT_THAT(objects[2].links, ElementsAre("GA-1", "GA-2"));
}

TEST(ProjectDocuments, CountsAreBounded) {
  std::string text = "<KNX><Installation>";
  for (std::size_t i = 0; i <= kMaxSpaces; ++i) text += "<Space/>";
  InstallationDocument document;
  EXPECT_THAT(document.read_text(text).error().text, HasSubstr("more than 65536 rooms"));
  std::string names = "<KNX><GroupRange Name='" + std::string(4000, 'x') + "'>";
  for (int i = 0; i < 20'000; ++i) names += "<GroupAddress/>";
  InstallationDocument long_names;
  EXPECT_THAT(long_names.read_text(names).error().text, HasSubstr("bytes of names and texts"));
}

}  // namespace
}  // namespace rubicon::networks::knx::project
