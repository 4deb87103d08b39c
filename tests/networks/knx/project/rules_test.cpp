#include <fmt/format.h>

#include <map>
#include <set>

#include "networks/knx/project/installation_document.h"
#include "networks/knx/project/programs.h"
#include "networks/knx/project/support.h"
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
  const std::vector<std::pair<std::string_view, std::string_view>> arguments{{"Number", "3"}};
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
  static std::map<std::string, groups::NameWords> words;
  static std::set<std::string> channels;
  const auto word = words.try_emplace(function, groups::words_of(function)).first;
  return {device,        *channels.insert(channel).first,
          &word->second, nullptr,
          true,          has('C'),
          has('R'),      has('W'),
          has('T'),      std::move(links)};
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

TEST(ProjectUsage, OfAnAddressWithUnknownFlagsNothingIsKnown) {
  auto unknown = object("", {0});
  unknown.flags_known = false;
  EXPECT_THAT(usage_of({object("CW", {0, 1}), unknown}, addresses(), {}).uses,
              ElementsAre(Use::kUnknown, Use::kCommanded, Use::kUnknown, Use::kUnknown));
}

TEST(ProjectUsage, FlagsAreKnownIfThoseThatMatterAreStated) {
  using Flag = std::optional<bool>;
  const auto known = [](Flag communication, Flag read, Flag write, Flag transmit) {
    return ObjectTraits{communication, read, write, transmit}.flags_are_known();
  };
  EXPECT_TRUE(known(true, false, true, false));
  EXPECT_TRUE(known(false, {}, {}, {})) << "it does nothing on the bus";
  EXPECT_TRUE(known(true, {}, true, {})) << "it takes commands";
  EXPECT_TRUE(known(true, {}, false, true)) << "it reports";
  EXPECT_TRUE(known(true, false, false, false));
  EXPECT_FALSE(known({}, {}, {}, {}));
  EXPECT_FALSE(known({}, true, true, true));
  EXPECT_FALSE(known(true, true, {}, true));
  EXPECT_FALSE(known(true, {}, false, false));
}

TEST(ProjectIds, OfModulesAreThoseOfTheirDefinitions) {
  struct Case {
    const char *id, *definition, *module;
  };
  for (const auto& [id, definition, module] :
       {Case{"MD-2_M-20_MI-1_O-2_R-3", "MD-2_O-2_R-3", "MD-2_M-20_MI-1"},
        Case{"M-00FA_A-1_MD-1_M-2_MI-3_O-7_R-8", "M-00FA_A-1_MD-1_O-7_R-8", "MD-1_M-2_MI-3"},
        // ETS 6, a module in a module.
        Case{"MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_O-3-1_R-2", "MD-4_SM-1_O-3-1_R-2",
             "MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2"},
        Case{"MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_CH-4", "MD-4_SM-1_CH-4", "MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2"},
        Case{"M-00FA_A-1_O-7_R-8", "M-00FA_A-1_O-7_R-8", ""}, Case{"O-9_R-9", "O-9_R-9", ""},
        Case{"MD-4_M-15_MI-1", "MD-4_M-15_MI-1", ""}, Case{"MD-4_M-15_MI-_O-1", "MD-4_M-15_MI-_O-1", ""},
        Case{"SM-1_SM-1_O-3", "SM-1_SM-1_O-3", ""}, Case{"", "", ""}}) {
    std::string found;
    EXPECT_EQ(without_module(id, found), definition) << id;
    EXPECT_EQ(found, module) << id;
  }
}

TEST(ProjectDocuments, ObjectsWithoutLinksAreNotKept) {
  KeptTexts texts;
  InstallationDocument document(texts);
  ASSERT_TRUE(document.read_text(
      "<KNX><Installation><Area Address='1'><Line Address='1'><DeviceInstance Address='2'>"
      "<ComObjectInstanceRef RefId='M-00FA_A-1_O-7_R-8' Links=' GA-1  GA-2 '/>"
      "<ComObjectInstanceRef RefId='O-9_R-9'/></DeviceInstance></Line></Area></Installation></KNX>"));
  const auto installations = document.take();
  const auto& objects = installations.at(0).devices.at(0).objects;
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_THAT(objects[0].links, ElementsAre("GA-1", "GA-2"));
}

struct Bound {
  const char *begin, *element;
  std::size_t most;
  const char* what;
};

TEST(ProjectDocuments, CountsAreBounded) {
  const std::string device = "<Area Address='1'><Line Address='1'><DeviceInstance Address='2'>";
  const std::string module = device + "<ModuleInstance Id='MD-1'>", object = device + "<ComObjectInstanceRef>";
  for (const auto& [begin, element, most, what] :
       {Bound{"", "<Space/>", kMaxSpaces, "rooms"},
        Bound{"<Area Address='1'><Line Address='1'>", "<DeviceInstance Address='2'/>", kMaxDevices, "devices"},
        Bound{device.c_str(), "<ComObjectInstanceRef Links='G'/>", kMaxObjects, "linked communication objects"},
        Bound{object.c_str(), "<Send GroupAddressRefId='G'/>", kMaxLinks, "links of communication objects"},
        Bound{module.c_str(), "<Argument RefId='A' Value='1'/>", kMaxArguments, "arguments of modules"},
        Bound{"", "<Function/>", kMaxFunctions, "functions"},
        Bound{"<Function>", "<GroupAddressRef RefId='G' Role='r'/>", kMaxMembers, "addresses of functions"}}) {
    std::string text = std::string("<KNX>") + begin;
    for (std::size_t i = 0; i <= most; ++i) text += element;
    KeptTexts texts;
    InstallationDocument document(texts);
    const auto read = document.read_text(text);
    ASSERT_FALSE(read) << what;
    EXPECT_THAT(read.error().text, HasSubstr(fmt::format("more than {} {}: file refused", most, what)));
  }
}

TEST(ProjectDocuments, FurtherAddressesAreLeftOutAndCounted) {
  std::string text = "<KNX>";
  for (std::size_t i = 0; i < groups::kMaxGroupAddresses + 7; ++i) text += "<GroupAddress/>";
  KeptTexts texts;
  InstallationDocument document(texts);
  EXPECT_FALSE(document.read_text(text)) << "the root element is open";
  EXPECT_EQ(document.addresses_left_out(), 7U);
  EXPECT_EQ(document.take().at(0).addresses.size(), groups::kMaxGroupAddresses);
}

TEST(KeptTexts, EachTextIsKeptOnceAndCounted) {
  KeptTexts texts(1000);
  const std::string word(100, 'x');
  const auto kept = texts.keep(word);
  EXPECT_EQ(kept, word);
  EXPECT_NE(kept.data(), word.data());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(texts.keep(word).data(), kept.data());
  EXPECT_FALSE(texts.is_exceeded());
  EXPECT_TRUE(texts.charge(700));
  EXPECT_FALSE(texts.charge(200));
  EXPECT_TRUE(texts.is_exceeded());
  EXPECT_EQ(texts.keep("another"), "");
  EXPECT_EQ(texts.keep(word), word) << "it is there already";
  EXPECT_EQ(kept, word);
  EXPECT_THAT(texts.why(), HasSubstr("more than 1000 bytes of names and texts"));
}

}  // namespace
}  // namespace rubicon::networks::knx::project
