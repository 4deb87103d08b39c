#include <gmock/gmock.h>

#include "networks/zigbee/bridge/bridge_lists.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(InventoryRecords, ADeviceWaitsUntilItsInterviewIsDone) {
  ObservedInventory seen;
  TestRecord device{1, "0x00124b0000000001", "IN_PROGRESS", "Unknown", "", false, false, ""};
  EXPECT_THAT(seen.list(list_of({device})), ElementsAre(HasSubstr("waiting 01: the interview is in progress")));
  device.type = "Router";
  device.interview = "FAILED";
  EXPECT_THAT(seen.list(list_of({device})), ElementsAre(HasSubstr("interview failed")));
  device.interview = "PENDING";
  EXPECT_THAT(seen.list(list_of({device})), ElementsAre(HasSubstr("the interview has not started")));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("changed 01: lamp"));
}

TEST(InventoryRecords, AnUnsupportedOrDisabledDeviceWaitsAndSaysWhatToDo) {
  ObservedInventory seen;
  TestRecord unknown{1, "thing"};
  unknown.supported = false;
  TestRecord off{2, "plug"};
  off.disabled = true;
  EXPECT_THAT(seen.list(list_of({unknown, off})),
              ElementsAre(HasSubstr("does not support the model 'M' of 'V'; update Zigbee2MQTT"),
                          "waiting 02: disabled in Zigbee2MQTT; enable it there"));
  EXPECT_EQ(seen.inventory.size(), 2U);
  std::vector<std::string> usable;
  seen.inventory.each([&](const auto& record, const auto& why) {
    if (why.empty()) usable.push_back(record.name);
  });
  EXPECT_THAT(usable, IsEmpty());
}

TEST(InventoryRecords, AUsableDeviceThatIsInterviewedAgainStaysUsableAndFollowsItsName) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  const TestRecord again{1, "lamp", "IN_PROGRESS", "Unknown", "", false, false, ""};
  EXPECT_THAT(seen.list(list_of({again})), IsEmpty());
  auto renamed = again;
  renamed.name = "light";
  EXPECT_THAT(seen.list(list_of({renamed})), ElementsAre("changed 01: light"));
  const auto* record = seen.inventory.find(test_address(1));
  EXPECT_EQ(record->leaves.size(), 1U);
  EXPECT_EQ(record->role, Role::kRouter);
  EXPECT_EQ(record->model, "M");
  EXPECT_TRUE(record->mains());
  EXPECT_THAT(seen.list(list_of({{1, "light"}})), IsEmpty());
}

TEST(InventoryRecords, AUsableDeviceThatIsDisabledWaits) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  TestRecord off{1, "lamp"};
  off.disabled = true;
  EXPECT_THAT(seen.list(list_of({off})), ElementsAre(HasSubstr("waiting 01: disabled")));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("changed 01: lamp"));
}

TEST(InventoryRecords, ANewDefinitionIsAChange) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  TestRecord other{1, "lamp"};
  other.exposes = kThermometer;
  EXPECT_THAT(seen.list(list_of({other})), ElementsAre("changed 01: lamp"));
  EXPECT_EQ(seen.inventory.find(test_address(1))->leaves.at(0).name, "temperature");
}

TEST(InventoryRecords, ARecordThatCannotBeReadKeepsTheDeviceAndIsReportedOnce) {
  ObservedInventory seen;
  const TestRecord plug{2, "plug"};
  seen.list(list_of({{1, "lamp"}, plug}));
  const auto bad = R"({"ieee_address":"0x)" + test_address(1) + R"(","definition":{"exposes":7}})";
  EXPECT_THAT(seen.list(list_of_texts({bad, plug.text()})), ElementsAre(HasSubstr("exposes")));
  EXPECT_THAT(seen.list(list_of_texts({plug.text(), bad})), IsEmpty());
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
  EXPECT_EQ(seen.inventory.find(test_address(1))->name, "lamp");
}

TEST(InventoryRecords, ADeviceWhoseNameBecomesUnusableWaits) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.list(list_of({{1, "a+b"}})), ElementsAre(HasSubstr("waiting 01: the friendly name has a wildcard")));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("changed 01: lamp"));
}

TEST(InventoryRecords, WhileARecordHasNoAddressNoDeviceIsAbsent) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  const TestRecord lamp{1, "lamp"};
  EXPECT_THAT(seen.list(list_of_texts({lamp.text(), R"({"friendly_name":"who"})"})),
              ElementsAre(HasSubstr("no ieee_address")));
  EXPECT_THAT(seen.list(list_of_texts({R"({"friendly_name":"who"})", lamp.text()})), IsEmpty());
  EXPECT_THAT(seen.list(list_of_texts({lamp.text(), "17"})), ElementsAre(HasSubstr("not an object")));
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
  EXPECT_EQ(seen.inventory.size(), 2U);
}

TEST(InventoryRecords, TooLongAndTooDeepRecordsAreNotRead) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  TestRecord large{1, "large"}, deep{2, "deep"};
  large.more = R"(,"text":")" + std::string(kMaxRecordBytes, 'x') + '"';
  deep.more = R"(,"deep":)" + std::string(100, '[') + std::string(100, ']');
  EXPECT_THAT(seen.list(list_of({large, deep})), ElementsAre(HasSubstr("more than 131072"), HasSubstr("deep")));
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
  EXPECT_EQ(seen.inventory.find(test_address(1))->name, "lamp");
}

TEST(InventoryRecords, AListThatIsNoneChangesNothing) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  const auto cut = list_of({{2, "plug"}});
  for (const auto& text :
       {std::string("{}"), std::string("17"), std::string("["), std::string("nonsense"), std::string("[}"),
        std::string("\xff\xfe"), cut.substr(0, cut.size() - 3), std::string("[] []"), std::string(1'000'000, '[')}) {
    EXPECT_THAT(seen.list(text), ElementsAre(HasSubstr("unreadable: bridge/devices"))) << text.substr(0, 40);
    EXPECT_THAT(seen.list(text), IsEmpty()) << "reported once: " << text.substr(0, 40);
  }
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
  EXPECT_EQ(seen.inventory.size(), 1U);
}

TEST(InventoryRecords, OfTwoRecordsOfOneDeviceTheFirstCounts) {
  ObservedInventory seen;
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {1, "other"}})), ElementsAre("changed 01: lamp",
                                                                           "unreadable: bridge/devices: 0x0012"
                                                                           "4b0000000001 is there twice"));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {1, "other"}, {2, "plug"}})), ElementsAre("changed 02: plug"));
  EXPECT_THAT(seen.list(list_of({{1, "other"}, {2, "plug"}})), ElementsAre("changed 01: other"));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "plug"}})), ElementsAre("changed 01: lamp"));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {1, "lamp"}, {2, "plug"}})), IsEmpty());
}

TEST(InventoryRecords, ARecordThatWasTheSecondOfTwoCountsAgainWhenItIsAlone) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.list(list_of({{1, "other"}, {1, "lamp"}})),
              ElementsAre("changed 01: other", HasSubstr("is there twice")));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("changed 01: lamp"));
}

TEST(InventoryRecords, DevicesBeyondTheBoundAreLeftOutUntilThereIsRoom) {
  ObservedInventory seen(2);
  EXPECT_THAT(seen.list(list_of({{1, "a"}, {2, "b"}, {3, "c"}, {4, "d"}})),
              ElementsAre("changed 01: a", "changed 02: b", HasSubstr("more than 2 devices (limits.devices)")));
  const auto parsed = seen.inventory.counters().parsed;
  EXPECT_THAT(seen.list(list_of({{1, "a"}, {2, "b"}, {4, "d"}, {3, "c"}})), IsEmpty());
  EXPECT_EQ(seen.inventory.counters().parsed, parsed) << "those that are left out are not parsed again";
  seen.inventory.leaving(test_address(1));
  EXPECT_THAT(seen.list(list_of({{2, "b"}, {3, "c"}, {4, "d"}})), ElementsAre(HasSubstr("left 01")));
  EXPECT_THAT(seen.list(list_of({{2, "b"}, {4, "d"}, {3, "c"}})), ElementsAre("changed 04: d"));
}

TEST(InventoryRecords, AListOfFarTooManyRecordsIsCut) {
  ObservedInventory seen(5);
  std::vector<TestRecord> records;
  for (unsigned i = 1; i <= 2000; ++i) records.push_back({i, fmt::format("device {}", i)});
  seen.list(list_of(records));
  EXPECT_EQ(seen.inventory.size(), 5U);
  EXPECT_LE(seen.inventory.counters().parsed, 2 * 5U + 100);
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
