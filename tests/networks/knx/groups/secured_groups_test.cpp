#include "networks/knx/groups/import.h"

#include <gmock/gmock.h>

#include "config/yaml.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/support.h"

namespace rubicon::networks::knx::groups {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kHead = "Group name;Address;Central;Unfiltered;Description;DatapointType;Security\n";

GroupList list_of(std::initializer_list<std::pair<const char*, const char*>> entries, bool knows_plain) {
  GroupList list;
  list.knows_plain = knows_plain;
  for (const auto& [address, security] : entries) {
    GroupEntry entry;
    entry.address = ga(address);
    entry.security = security;
    entry.secured = entry.security == "On";
    list.entries.push_back(entry);
  }
  return list;
}

TEST(SecuredGroups, OfAListAreThoseThatAreOn) {
  const auto imported = import_text(
      std::string(kHead) + "A;1/0/3;;;;;On\nB;1/0/2;;;;;Auto\nC;1/0/1;;;;;on\nD;1/0/4;;;;;Off\n", "flat.csv");
  EXPECT_THAT(imported->secured, ElementsAre(ga("1/0/1"), ga("1/0/3")));
  EXPECT_EQ(imported->report.secured, 2U);
}

TEST(SecuredGroups, AreWrittenToAGroupFileAndReadBack) {
  std::vector<wire::GroupAddress> secured;
  for (std::uint16_t i = 1; i <= 25; ++i) secured.push_back(wire::GroupAddress(i));
  const auto yaml = to_yaml({}, "x", secured);
  EXPECT_THAT(yaml, HasSubstr("secured-groups: [0/0/1, 0/0/2, "));
  const auto node = config::parse_yaml(yaml, "home.yaml");
  ASSERT_TRUE(node) << node.error().text;
  ConfigErrors errors;
  ConfigReader reader(*node, "", errors);
  std::vector<GroupPoint> none;
  read_groups(reader, none);
  EXPECT_EQ(read_secured_groups(reader), secured);
  reader.finish();
  EXPECT_EQ(errors.text(), "");
}

TEST(SecuredGroups, AreSortedOnceAndWithoutWhatIsNoAddress) {
  const auto node = config::parse_yaml("secured-groups: [1/0/2, 1/0/1, 1/513, 9/9/999]\n", "home.yaml");
  ConfigErrors errors;
  ConfigReader reader(*node, "", errors);
  EXPECT_THAT(read_secured_groups(reader), ElementsAre(ga("1/0/1"), ga("1/0/2"), ga("1/2/1")));
  EXPECT_THAT(errors.text(), HasSubstr("secured-groups"));
}

TEST(SecuredGroups, OfAGroupFileFollowAProject) {
  Report report;
  const auto project = list_of({{"1/0/1", "Auto"}, {"1/0/2", "On"}, {"1/0/3", "On"}}, true);
  EXPECT_THAT(merge_secured({ga("1/0/1"), ga("1/0/2"), ga("1/0/9")}, project, report),
              ElementsAre(ga("1/0/2"), ga("1/0/3"), ga("1/0/9")));
  EXPECT_EQ(report.warnings, 1U);
  EXPECT_THAT(report.findings.at(0).text, HasSubstr("no longer secured"));
  EXPECT_THAT(report.findings.at(1).text, HasSubstr("secured from now on"));
}

TEST(SecuredGroups, StayWhereAListDoesNotKnow) {
  Report report;
  const auto list = list_of({{"1/0/1", "Auto"}, {"1/0/2", "Off"}}, false);
  EXPECT_THAT(merge_secured({ga("1/0/1"), ga("1/0/2")}, list, report), ElementsAre(ga("1/0/1")));
}

TEST(SecuredGroups, AreMergedByAnImport) {
  ImportOptions options;
  options.known = std::vector<GroupPoint>();
  options.known_secured = {ga("1/0/1")};
  const auto imported = import_text(std::string(kHead) + "A;1/0/1;;;;;Auto\nB;1/0/2;;;;;On\n", "flat.csv", options);
  EXPECT_THAT(imported->secured, ElementsAre(ga("1/0/1"), ga("1/0/2")));
}

TEST(SecuredGroups, OfTwoSourcesAreJoined) {
  EXPECT_THAT(joined({ga("1/0/1"), ga("1/0/3")}, {ga("1/0/2"), ga("1/0/3")}),
              ElementsAre(ga("1/0/1"), ga("1/0/2"), ga("1/0/3")));
  EXPECT_THAT(joined({}, {}), IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::knx::groups
