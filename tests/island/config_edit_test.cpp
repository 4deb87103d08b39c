#include "island/config_edit.h"

#include <gmock/gmock.h>

namespace rubicon::island {
namespace {

using testing::HasSubstr;

constexpr const char* kKnx = "type: knx\nhost: 10.0.0.9\n";

std::string added(const std::string& text, const std::string& options = kKnx) {
  const auto next = with_network(text, "home.yaml", "knx-2", options);
  return next ? *next : "error: " + next.error().text;
}

TEST(ConfigEdit, ANetworkGoesToTheEndAndAllElseStays) {
  EXPECT_EQ(added("# my house\n"
                  "island: {id: 1, name: home}   # the first\n"
                  "networks:\n"
                  "    # motes of the hall\n"
                  "    wsn-1: {type: wsn, source: \"file@x\"}  # old\n"
                  "    # more to come\n"
                  "\n"
                  "# what is kept\n"
                  "state: {file: home.state}\n"),
            "# my house\n"
            "island: {id: 1, name: home}   # the first\n"
            "networks:\n"
            "    # motes of the hall\n"
            "    wsn-1: {type: wsn, source: \"file@x\"}  # old\n"
            "    # more to come\n"
            "    knx-2:\n"
            "      type: knx\n"
            "      host: 10.0.0.9\n"
            "\n"
            "# what is kept\n"
            "state: {file: home.state}\n");
}

TEST(ConfigEdit, EachWayToWriteNetworksHasItsPlace) {
  EXPECT_EQ(added("island: {id: 1}\n"), "island: {id: 1}\nnetworks:\n  knx-2:\n    type: knx\n    host: 10.0.0.9\n");
  EXPECT_EQ(added("island: {id: 1}"), "island: {id: 1}\nnetworks:\n  knx-2:\n    type: knx\n    host: 10.0.0.9\n");
  EXPECT_EQ(added("networks:\nisland: {id: 1}\n"),
            "networks:\n  knx-2:\n    type: knx\n    host: 10.0.0.9\nisland: {id: 1}\n");
  EXPECT_EQ(added("networks: {}  # none yet\nisland: {id: 1}\n"),
            "networks: {knx-2: {type: knx, host: 10.0.0.9}}  # none yet\nisland: {id: 1}\n");
  EXPECT_EQ(added("networks: {a: {type: dummy}}\n", "{type: knx, host: \"a: b\"}"),
            "networks: {knx-2: {type: knx, host: \"a: b\"}, a: {type: dummy}}\n");
  EXPECT_EQ(added("networks:\n  a: {type: dummy}", "{type: dummy,\n   seed: 7}\n"),
            "networks:\n  a: {type: dummy}\n  knx-2: {type: dummy,\n       seed: 7}\n");
}

TEST(ConfigEdit, LinesEndAsThoseOfTheFileDo) {
  EXPECT_EQ(added("networks:\r\n  a: {type: dummy}\r\n\r\nisland: {id: 1}\r\n"),
            "networks:\r\n  a: {type: dummy}\r\n  knx-2:\r\n    type: knx\r\n    host: 10.0.0.9\r\n\r\nisland: {id: "
            "1}\r\n");
  EXPECT_EQ(added("\xef\xbb\xbfnetworks: {}\n"), "\xef\xbb\xbfnetworks: {knx-2: {type: knx, host: 10.0.0.9}}\n");
}

TEST(ConfigEdit, OptionsWithAMarginAndTextsOfSeveralLinesStayWhatTheyAre) {
  EXPECT_EQ(added("networks:\n  a: {type: dummy}\n", "  type: dummy\n\n  note: |\n    one\n\n    two\n"),
            "networks:\n  a: {type: dummy}\n  knx-2:\n    type: dummy\n\n    note: |\n      one\n\n      two\n");
}

TEST(ConfigEdit, WhatCannotBeInsertedSafelyIsRefused) {
  EXPECT_THAT(added("networks:\n  - {type: dummy}\n"),
              HasSubstr("home.yaml:1:1: networks is a list, expected a map with a name for each, such as `dummy-1: "));
  EXPECT_THAT(added("networks: 7\n"), HasSubstr("networks is no map, expected one with a name for each"));
  EXPECT_THAT(added("networks: null\n"), HasSubstr("nothing can be inserted safely"));
  EXPECT_THAT(added("{island: {id: 1}}\n"), HasSubstr("nothing can be inserted safely"));
  EXPECT_THAT(added("island: {id: 1}\n...\n"), HasSubstr("nothing can be inserted safely"));
  EXPECT_THAT(added("networks:\n  knx-2: {type: dummy}\n"), HasSubstr("home.yaml:2:3: there is a network knx-2"));
  EXPECT_THAT(added("networks: {\n"), HasSubstr("home.yaml:1:11"));
  EXPECT_THAT(added("island: {id: 1}\n", "type: {"), HasSubstr("options:1:7"));
  EXPECT_THAT(added("island: {id: 1}\n", "just text"), HasSubstr("options:1:1: expected a map"));
  for (const auto* name : {"", "a b", "a.b", "knx: {}\nrights", "../x"})
    EXPECT_FALSE(with_network("island: {id: 1}\n", "home.yaml", name, kKnx)) << name;
}

/// Options that would end the entry, and add another section.
TEST(ConfigEdit, OptionsNeverReachOutOfTheirNetwork) {
  EXPECT_THAT(added("networks:\n  a: {type: dummy}\n", "type: knx\n...\nrights: []\n"), testing::StartsWith("error: "));
  EXPECT_THAT(added("networks:\n  a: {type: dummy}\n", "{type: knx}\nrights: []"), testing::StartsWith("error: "));
  EXPECT_THAT(added("networks:\n  a: {type: dummy}\n", "type: knx\n---\nb: 1\n"), testing::StartsWith("error: "));
}

std::string with_import(const std::string& text, const std::string& value = "new.yaml") {
  const auto next = with_option(text, "home.yaml", "knx", "import", value);
  return next ? *next : "error: " + next.error().text;
}

TEST(ConfigEdit, AnOptionIsReplacedWhereItStandsOrComesFirst) {
  EXPECT_EQ(with_import("networks:\n  knx:\n    # the hall\n    type: knx\n    import: old.csv   # of ETS\n"),
            "networks:\n  knx:\n    # the hall\n    type: knx\n    import: new.yaml   # of ETS\n");
  EXPECT_EQ(with_import("networks:\n  knx:\n    import: 'my old.csv'  # of ETS\n    type: knx\n", "a b.yaml"),
            "networks:\n  knx:\n    import: \"a b.yaml\"  # of ETS\n    type: knx\n");
  EXPECT_EQ(with_import("networks:\n  knx:\n    # the hall\n    type: knx\n"),
            "networks:\n  knx:\n    import: new.yaml\n    # the hall\n    type: knx\n");
  EXPECT_EQ(with_import("networks:\n  knx: {type: knx, name: \"K\xc3\xbc"
                        "che\", host: a}\n"),
            "networks:\n  knx: {import: new.yaml, type: knx, name: \"K\xc3\xbc"
            "che\", host: a}\n");
  EXPECT_EQ(with_import("networks: {knx: {name: \"K\xc3\xbc"
                        "che\", import: old.csv}}\n"),
            "networks: {knx: {name: \"K\xc3\xbc"
            "che\", import: new.yaml}}\n");
}

TEST(ConfigEdit, AnOptionThatIsNoTextOnOneLineIsLeftToItsAuthor) {
  EXPECT_THAT(with_import("networks:\n  knx:\n    type: knx\n    import: [a, b]\n"), HasSubstr("home.yaml:4:5"));
  EXPECT_THAT(with_import("networks:\n  knx:\n    type: knx\n    import: >-\n      old.csv\n"),
              HasSubstr("is not a text on one line"));
  EXPECT_THAT(with_import("networks:\n  other: {type: knx}\n"), HasSubstr("there is no network knx"));
  EXPECT_THAT(with_import("networks:\n  knx:\n"), HasSubstr("has no options"));
}

TEST(ConfigEdit, AScalarIsReadAsTheSameText) {
  EXPECT_EQ(scalar_text("knx-hall.groups.yaml"), "knx-hall.groups.yaml");
  EXPECT_EQ(scalar_text("-1"), "-1");
  EXPECT_EQ(scalar_text("- x"), "\"- x\"");
  EXPECT_EQ(scalar_text(""), "\"\"");
  EXPECT_EQ(scalar_text("null"), "\"null\"");
  EXPECT_EQ(scalar_text("a\"\\\n"), "\"a\\\"\\\\\\x0a\"");
}

TEST(ConfigEdit, ThePatchIsWhatAPersonInserts) {
  EXPECT_EQ(network_text("knx-2", "type: knx\nhost: a\n"), "networks:\n  knx-2:\n    type: knx\n    host: a\n");
  EXPECT_EQ(network_text("knx-2", "{type: knx}"), "networks:\n  knx-2: {type: knx}\n");
}

}  // namespace
}  // namespace rubicon::island
