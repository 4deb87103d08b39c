#include <gmock/gmock.h>

#include "networks/zigbee/bridge/bridge_lists.h"

// Retained copies of the list, which may be older than what the bridge knows.
namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr const char* kPlugLeft = "left 02: removed from Zigbee2MQTT";

struct RetainedLists : testing::Test {
  void SetUp() override {
    seen.list(whole);
    seen.inventory.line_lost();
  }
  std::vector<std::string> retained(const std::string& payload) {
    seen.inventory.list(payload, true);
    return seen.run();
  }
  const std::string whole = list_of({{1, "lamp"}, {2, "plug"}}), old = list_of({{1, "lamp"}});
  ObservedInventory seen;
};

TEST_F(RetainedLists, AreRead) {
  EXPECT_THAT(retained(list_of({{1, "lamp"}, {2, "plug"}, {3, "fan"}})), ElementsAre("changed 03: fan"));
}

TEST_F(RetainedLists, RemoveADeviceOnlyAfterALongTimeWithoutASignOfLife) {
  EXPECT_THAT(retained(old), IsEmpty());
  EXPECT_THAT(seen.run_for(25h - 1ms), IsEmpty());
  EXPECT_THAT(seen.run_for(1ms), ElementsAre(kPlugLeft));
}

TEST_F(RetainedLists, DoNotRemoveADeviceThatIsHeardAfterOrBeforeThem) {
  retained(old);
  seen.inventory.heard(test_address(2));
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
  seen.inventory.line_lost();
  seen.inventory.heard(test_address(2));
  EXPECT_THAT(retained(old), IsEmpty());
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
  seen.inventory.line_lost();
  retained(old);
  EXPECT_THAT(seen.run_for(25h), ElementsAre(kPlugLeft)) << "a sign of life counts for one connection";
}

TEST_F(RetainedLists, TwoDifferentOnesDoNotRemoveADevice) {
  retained(old);
  EXPECT_THAT(retained(list_of({{1, "light"}})), ElementsAre("changed 01: light"));
  EXPECT_THAT(seen.run_for(1h), IsEmpty());
}

TEST_F(RetainedLists, ALiveListDecidesAlsoIfItIsTheSame) {
  retained(old);
  seen.inventory.heard(test_address(2));
  EXPECT_THAT(seen.list(old), IsEmpty()) << "a complete list can follow a short one";
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft));
}

TEST_F(RetainedLists, ALiveListThatHasTheDeviceKeepsIt) {
  retained(old);
  EXPECT_THAT(seen.list(whole), IsEmpty());
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
}

TEST_F(RetainedLists, AfterALiveListTheyCountAsLive) {
  seen.list(whole);
  retained(old);
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft));
}

TEST_F(RetainedLists, ALiveCopyThatArrivesBeforeTheRetainedOneIsComparedCounts) {
  seen.inventory.list(old, true);
  seen.inventory.list(old);
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft));
}

TEST_F(RetainedLists, ADeviceThatReportedItsLeaveIsGoneWithARetainedListToo) {
  seen.inventory.leaving(test_address(2));
  EXPECT_THAT(retained(old), ElementsAre("left 02: left the ZigBee network"));
}

/// Devices that were there before the inventory.
struct ExpectedDevices : testing::Test {
  void expect(unsigned number) { seen.inventory.expect(test_address(number)); }
  const std::string whole = list_of({{1, "lamp"}, {2, "plug"}}), old = list_of({{1, "lamp"}});
  ObservedInventory seen;
};

TEST_F(ExpectedDevices, LeaveSomeTimeAfterALiveListThatLacksThem) {
  expect(2);
  EXPECT_THAT(seen.run_for(72h), IsEmpty()) << "without a list nothing is known";
  seen.list(old);
  EXPECT_THAT(seen.run_for(10s - 1ms), IsEmpty());
  EXPECT_THAT(seen.run_for(1ms), ElementsAre(kPlugLeft));
  seen.list(whole);
  seen.list(old);
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft)) << "it is like any other device";
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
}

TEST_F(ExpectedDevices, MayBeNamedAfterTheList) {
  seen.list(old);
  expect(1);
  expect(2);
  expect(2);
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft));
}

TEST_F(ExpectedDevices, WaitLongWhereOnlyARetainedListLacksThem) {
  seen.inventory.list(old, true);
  seen.run();
  expect(2);
  EXPECT_THAT(seen.run_for(24h), IsEmpty());
  EXPECT_THAT(seen.run_for(1h), ElementsAre(kPlugLeft));
}

TEST_F(ExpectedDevices, StayWhileAListHasThem) {
  seen.inventory.list(old, true);
  seen.run();
  expect(2);
  seen.list(whole);
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
}

TEST_F(ExpectedDevices, StayWhereTheirRecordsCannotBeRead) {
  auto unreadable = TestRecord{2, "plug"};
  unreadable.exposes = "7";
  const auto list = list_of({{1, "lamp"}, unreadable});
  expect(2);
  seen.list(list);
  seen.inventory.expect(test_address(2));
  seen.list(list_of({{1, "light"}, unreadable}));
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
  seen.list(old);
  EXPECT_THAT(seen.run_for(10s), ElementsAre(kPlugLeft));
}

TEST_F(ExpectedDevices, GetAnotherChanceAfterTheLineWasLost) {
  seen.list(old);
  expect(2);
  seen.run_for(5s);
  seen.inventory.line_lost();
  expect(3);
  EXPECT_THAT(seen.run_for(72h), IsEmpty());
  seen.list(whole);
  EXPECT_THAT(seen.run_for(10s), ElementsAre("left 03: removed from Zigbee2MQTT"));
}

TEST_F(ExpectedDevices, AreAsManyAsDevicesAtMost) {
  ObservedInventory small(2);
  for (unsigned i = 1; i <= 3; ++i) small.inventory.expect(test_address(i));
  small.list("[]");
  EXPECT_THAT(small.run_for(10s),
              ElementsAre("left 01: removed from Zigbee2MQTT", "left 02: removed from Zigbee2MQTT"));
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
