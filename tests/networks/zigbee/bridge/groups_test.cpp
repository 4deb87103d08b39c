#include "networks/zigbee/bridge/groups.h"

#include <gmock/gmock.h>

#include "networks/zigbee/bridge/bridge_lists.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string light(int warmest, const char* more = "") {
  return fmt::format(
      R"([{{"type":"light","features":[{{"type":"binary","name":"state","property":"state","access":7,"value_on":"ON",)"
      R"("value_off":"OFF"}},{{"type":"numeric","name":"color_temp","property":"color_temp","access":7,"unit":"mired",)"
      R"("value_min":150,"value_max":{}}},{{"type":"composite","name":"color_xy","property":"color","access":7,)"
      R"("features":[{{"type":"numeric","name":"x","property":"x","access":7}}]}},{{"type":"composite",)"
      R"("name":"color_hs","property":"color","access":7,"features":[{{"type":"numeric","name":"hue",)"
      R"("property":"hue","access":7}}]}},{{"type":"enum","name":"mode","property":"mode","access":1,)"
      R"("values":["a"]}}]}},{{"type":"enum","name":"effect","property":"effect","access":2,"values":["blink"]}}{}])",
      warmest, more);
}

std::string dimmer(const char* bounds) {
  return fmt::format(R"([{{"type":"light","features":[{{"type":"numeric","name":"brightness","property":"brightness",)"
                     R"("access":7{}}}]}}])",
                     bounds);
}

/// Devices by their number, as an inventory has them.
struct Members {
  std::map<std::string, DeviceRecord> devices;

  void put(unsigned number, const std::string& exposes) {
    TestRecord record{number, fmt::format("device {}", number)};
    record.exposes = exposes;
    auto read = read_device_record(record.text());
    ASSERT_TRUE(read) << read.error().text;
    devices[read->address] = *read;
  }
  const DeviceRecord* find(const std::string& address) const {
    const auto found = devices.find(address);
    return found == devices.end() ? nullptr : &found->second;
  }
  std::map<std::string, DeviceRecord> records(const std::vector<Group>& list) const {
    Groups groups;
    std::ignore = groups.replace(list, [this](const std::string& address) { return find(address); });
    return groups.records();
  }
};

std::vector<std::string> shown(const DeviceRecord& record) {
  std::vector<std::string> leaves;
  for (const auto& leaf : record.leaves) leaves.push_back(leaf.group + "." + leaf.name + "=" + leaf.property);
  return leaves;
}

TEST(Groups, AreReadWithTheirMembersAndWithoutTheBridgesOwn) {
  const auto list = read_groups(
      R"([{"friendly_name":"default_bind_group","id":901,"members":[],"scenes":[]},
          {"friendly_name":"hall/lamps","id":7,"description":"Hall","scenes":[],"members":[
            {"endpoint":11,"ieee_address":"0x00124B0000000001"},{"endpoint":1,"ieee_address":"0x00124b0000000001"},
            {"endpoint":1,"ieee_address":"0x00124b0000000002"},{"ieee_address":"lamp"},7]}])");
  ASSERT_TRUE(list);
  EXPECT_THAT(list->groups, ElementsAre(Group{7, "hall/lamps", "Hall", {"00124b0000000001", "00124b0000000002"}}));
  EXPECT_EQ(list->groups[0].address(), "group-7");
  EXPECT_THAT(list->skipped, IsEmpty());
}

TEST(Groups, ABadRecordIsSkippedAndABadListIsNotRead) {
  const auto list = read_groups(
      R"([7,{"friendly_name":"a"},{"id":1,"friendly_name":"a+"},{"id":2,"friendly_name":"b"},{"id":2,"friendly_name":"c"},
          {"id":-3,"friendly_name":"d"},{"id":4,"friendly_name":"e","members":null}])");
  ASSERT_TRUE(list);
  ASSERT_EQ(list->groups.size(), 3U);
  EXPECT_THAT(list->groups[0].unusable_name, HasSubstr("wildcard")) << "it is there, and waits";
  EXPECT_THAT(list->skipped, ElementsAre(HasSubstr("not an object"), HasSubstr("no id"), "group 2: is there twice",
                                         HasSubstr("no id")));
  for (const auto* text : {"", "{}", "[", "null"}) EXPECT_FALSE(read_groups(text)) << text;
}

TEST(Groups, HaveTheLightSwitchAndCoverLeavesThatAMemberLetsUsSet) {
  Members members;
  members.put(1, light(400));
  members.put(2, light(500));
  members.put(3, kSwitch);
  const auto records = members.records({{7, "lamps", "", {test_address(3), test_address(1), test_address(2)}}});
  const auto& group = records.at("group-7");
  EXPECT_THAT(shown(group), ElementsAre("light.state=state", "light.color_temp=color_temp", "light.color_xy=color",
                                        "light.color_hs=color"));
  EXPECT_EQ(group.leaves[1].maximum, 500) << "the widest bounds";
  for (const auto& leaf : group.leaves) EXPECT_FALSE(leaf.access.gettable) << leaf.name;
  EXPECT_TRUE(group.is_group());
  EXPECT_FALSE(group.mains());
  EXPECT_EQ(why_waiting(group), "");
  EXPECT_EQ(group.name, "lamps");
}

TEST(Groups, HaveNoEndpointsOfTheirMembers) {
  Members members;
  members.put(1, R"([{"type":"switch","endpoint":"left","features":[{"type":"binary","name":"state","endpoint":"left",
    "property":"state_left","access":7,"value_on":"ON","value_off":"OFF"}]},
    {"type":"switch","endpoint":"right","features":[{"type":"binary","name":"state","endpoint":"right",
    "property":"state_right","access":7,"value_on":"ON","value_off":"OFF"}]}])");
  const auto records = members.records({{7, "both", "", {test_address(1)}}});
  EXPECT_THAT(shown(records.at("group-7")), ElementsAre("switch.state=state"));
  EXPECT_EQ(records.at("group-7").leaves[0].endpoint, "");
}

TEST(Groups, ACoverAmongLampsKeepsItsOwnState) {
  Members members;
  members.put(1, kSwitch);
  members.put(2, R"([{"type":"cover","features":[{"type":"enum","name":"state","property":"state","access":3,
    "values":["OPEN","CLOSE","STOP"]},{"type":"numeric","name":"position","property":"position","access":7,
    "value_min":0,"value_max":100}]}])");
  const auto records = members.records({{7, "mixed", "", {test_address(1), test_address(2)}}});
  EXPECT_THAT(shown(records.at("group-7")),
              ElementsAre("switch.state=state", "cover.state=state", "cover.position=position"));
}

TEST(Groups, HaveNoBoundThatAMemberLacks) {
  Members members;
  members.put(1, dimmer(R"(,"value_min":0,"value_max":254,"value_step":2)"));
  members.put(2, dimmer(""));
  members.put(3, dimmer(R"(,"value_min":-5,"value_max":100,"value_step":5)"));
  const auto bounds = [&](const std::vector<unsigned>& numbers) {
    Group group{7, "lamps", "", {}};
    for (const auto number : numbers) group.members.push_back(test_address(number));
    const auto leaf = members.records({group}).at("group-7").leaves.at(0);
    return std::vector{leaf.minimum, leaf.maximum, leaf.step};
  };
  const std::vector<std::optional<double>> none(3), widest{-5, 254, 2};
  EXPECT_EQ(bounds({1, 2}), none);
  EXPECT_EQ(bounds({2, 1}), none);
  EXPECT_EQ(bounds({1, 2, 3}), none);
  EXPECT_EQ(bounds({1, 3}), widest);
  EXPECT_EQ(bounds({3, 1}), widest);
}

TEST(Groups, ChangeWithTheirMembersNamesAndRemoval) {
  Members members;
  const auto find = [&](const std::string& address) { return members.find(address); };
  members.put(1, kSwitch);
  const std::vector<std::string> both{test_address(1), test_address(2)};
  Groups groups;
  EXPECT_EQ(groups.replace({{7, "lamps", "", both}}, find).changed.size(), 1U);
  EXPECT_THAT(groups.replace({{7, "lamps", "", both}}, find).changed, IsEmpty());
  members.put(2, light(400));
  EXPECT_EQ(groups.members_changed({test_address(2)}, find).changed.size(), 1U)
      << "a member that appears brings its leaves";
  EXPECT_THAT(groups.members_changed({test_address(2)}, find).changed, IsEmpty());
  EXPECT_EQ(groups.replace({{7, "hall", "", both}}, find).changed.at(0).name, "hall");
  EXPECT_THAT(groups.replace({{7, "hall", "", {}}}, find).changed.at(0).leaves, IsEmpty());
  EXPECT_THAT(groups.replace({}, find).left, ElementsAre("group-7"));
  EXPECT_THAT(groups.records(), IsEmpty());
}

TEST(Groups, OnlyThoseOfAChangedMemberAreBuiltAnew) {
  Members members;
  for (unsigned number = 1; number <= 4; ++number) members.put(number, kSwitch);
  std::vector<std::string> asked;
  const auto find = [&](const std::string& address) {
    asked.push_back(address);
    return members.find(address);
  };
  Groups groups;
  std::ignore = groups.replace(
      {{1, "a", "", {test_address(1), test_address(2)}}, {2, "b", "", {test_address(3), test_address(4)}}}, find);
  asked.clear();
  members.put(2, light(400));
  EXPECT_EQ(groups.members_changed({test_address(2)}, find).changed.at(0).address, "group-1");
  EXPECT_THAT(asked, ElementsAre(test_address(1), test_address(2)));
}

TEST(Groups, AreBounded) {
  std::string text = "[";
  for (int i = 1; i <= 1100; ++i)
    text += fmt::format(R"({}{{"id":{},"friendly_name":"g{}"}})", i == 1 ? "" : ",", i, i);
  const auto many = read_groups(text + "]");
  ASSERT_TRUE(many);
  EXPECT_EQ(many->groups.size(), 1000U);
  EXPECT_THAT(many->skipped, ElementsAre(HasSubstr("more than 1000 groups")));
  std::string members;
  for (unsigned i = 1; i <= 4000; ++i)
    members += fmt::format(R"({}{{"ieee_address":"0x{}"}})", i == 1 ? "" : ",", test_address(i));
  const auto large = read_groups(
      fmt::format(R"([{{"id":1,"friendly_name":"a","members":[{}]}},{{"id":2,"friendly_name":"b","members":[{}]}}])",
                  members, members));
  ASSERT_TRUE(large);
  EXPECT_EQ(large->groups.size(), 1U);
  EXPECT_THAT(large->skipped, ElementsAre(HasSubstr("more than 5000 members")));
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
