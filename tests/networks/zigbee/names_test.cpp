#include <fmt/format.h>

#include <fstream>

#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// Friendly names that cannot be topics, or are topics of something else.
class ZigbeeNames : public House {
 protected:
  json reply() const {
    const auto all = to_tools("zigbee.reply");
    return all.empty() ? json() : all.back();
  }
  /// Of `rubicon zigbee devices`: by address.
  std::map<std::string, std::string> why_not() {
    ask({{"id", "x"}, {"do", "devices"}});
    const auto answer = reply();
    std::map<std::string, std::string> found;
    for (const auto& one : answer["devices"])
      if (one.contains("why")) found[one["address"]] = one["why"];
    return found;
  }
};

TEST_F(ZigbeeNames, DevicesThatNoTopicCanNameAreListedWithTheReason) {
  make();
  bridge_starts({plug("with#hash"), thermometer("with+plus"), button("tab\tname")});
  say("bridge/groups", {{{"id", 7}, {"friendly_name", "all+"}, {"members", json::array()}}}, true);
  open();
  const auto why = why_not();
  ASSERT_THAT(why, SizeIs(4));
  EXPECT_THAT(why.at(kPlug), AllOf(HasSubstr("wildcard of MQTT"), HasSubstr("rubicon zigbee rename 00124b0010000002")));
  EXPECT_THAT(why.at(kThermometer), HasSubstr("wildcard of MQTT"));
  EXPECT_THAT(why.at(kButton), HasSubstr("control characters"));
  EXPECT_THAT(why.at("group-7"), HasSubstr("wildcard of MQTT"));
  std::map<std::string, model::Join> joins;
  for (const auto& [device, join] : host.all<model::Join>()) joins[device] = join;
  ASSERT_THAT(joins, SizeIs(4)) << "for the inbox";
  EXPECT_EQ(joins.at(kButton).name, "tab name");
  for (const auto& [device, join] : joins) EXPECT_EQ(join.problem, why.at(device));
  EXPECT_EQ(counter("unusable-names"), 4U);
  EXPECT_EQ(counter("unreadable-lists"), 0U);
  const auto listed = json::parse(state().texts.at("unusable"));
  ASSERT_THAT(listed, SizeIs(4));
  EXPECT_EQ(listed[0], json({{"address", kPlug}, {"name", "with#hash"}, {"why", why.at(kPlug)}}));
  const auto refused = command(1, kPlug, "switch", true);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("rename it"));
}

/// Names that people gave.
TEST_F(ZigbeeNames, FollowTheCases) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/zigbee/names.tsv");
  std::map<std::string, std::string> reasons;
  json devices = json::array();
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    const auto tab = line.find('\t');
    ASSERT_NE(tab, line.npos) << line;
    const auto address = fmt::format("00124b00100000{:02x}", devices.size());
    devices.push_back(plug(json::parse(line.substr(0, tab))));
    devices.back()["ieee_address"] = "0x" + address;
    reasons[address] = line.substr(tab + 1);
  }
  ASSERT_GE(devices.size(), 12U);
  make();
  bridge_starts(devices);
  open();
  const auto why = why_not();
  for (const auto& [address, reason] : reasons) {
    ASSERT_EQ(why.contains(address), !reason.empty()) << address;
    if (reason.empty()) continue;
    EXPECT_THAT(why.at(address), HasSubstr(reason));
  }
}

TEST_F(ZigbeeNames, ARenameHelps) {
  make();
  bridge_starts(json::array({plug("with#hash")}));
  open();
  ask({{"id", "r"}, {"do", "rename"}, {"device", kPlug}, {"to", "hall"}});
  EXPECT_EQ(requested("device/rename")["from"], "0x00124b0010000002");
  list(json::array({plug("hall")}));
  host.time.run_for(1s);
  EXPECT_THAT(why_not(), IsEmpty());
  EXPECT_EQ(state().texts.at("unusable"), "[]");
  EXPECT_TRUE(command(1, kPlug, "switch", true));
  list(json::array({plug("hall#")}));
  host.time.run_for(1s);
  EXPECT_THAT(why_not(), SizeIs(1)) << "it was usable before";
  EXPECT_FALSE(command(2, kPlug, "switch", true));
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
}

TEST_F(ZigbeeNames, TopicsOfOthersAreListedInTheSamePlace) {
  make();
  bridge_starts({plug("bridge/lamp"), thermometer("air"), button("air/set")});
  open();
  const auto why = why_not();
  ASSERT_THAT(why, SizeIs(2));
  EXPECT_THAT(why.at(kPlug), HasSubstr("topic of the bridge"));
  EXPECT_THAT(why.at(kButton), HasSubstr("commands to 'air'"));
  host.time.run_for(1s);
  EXPECT_THAT(json::parse(state().texts.at("unusable")), SizeIs(2));
}

TEST_F(ZigbeeNames, ReservedNamesAreRefusedBeforeTheBridgeHasThem) {
  start();
  for (const auto* name : {"air/set", "air/get", "other/set/left", "hall/air/availability", "bridge", "bridge/lamp", "",
                           "a#", "+", "/a", "a/", "tab\tname"}) {
    ask({{"id", name}, {"do", "rename"}, {"device", kPlug}, {"to", name}});
    EXPECT_EQ(reply()["id"], name);
    EXPECT_EQ(reply()["ok"], false) << name;
    EXPECT_NE(reply().value("why", ""), "") << name;
  }
  EXPECT_EQ(requested("device/rename"), json());
  ask({{"id", "x"}, {"do", "rename"}, {"device", kPlug}, {"to", "air/set"}});
  EXPECT_THAT(reply().value("why", ""), AllOf(HasSubstr("'air'"), HasSubstr("'/set' is reserved")));
  for (const auto* name : {"set", "get/x", "availability", "hall/availability/x", "bridges/lamp", "a/settee"}) {
    ask({{"id", "y"}, {"do", "rename"}, {"device", kPlug}, {"to", name}});
    EXPECT_EQ(requested("device/rename")["to"], name);
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee
