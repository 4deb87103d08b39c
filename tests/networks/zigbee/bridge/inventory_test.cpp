#include <gmock/gmock.h>

#include "networks/zigbee/bridge/bridge_lists.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr const char* kGone = "removed from Zigbee2MQTT";

TEST(Inventory, NewDevicesOfAListAreThereAndTheCoordinatorIsNone) {
  ObservedInventory seen;
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "plug"}})), ElementsAre("changed 01: lamp", "changed 02: plug"));
  EXPECT_EQ(seen.inventory.size(), 2U);
  EXPECT_EQ(seen.inventory.find(test_address(1))->name, "lamp");
  EXPECT_EQ(seen.inventory.find_named("plug")->address, test_address(2));
  EXPECT_EQ(seen.inventory.find("00124b00deadbeef"), nullptr);
  EXPECT_EQ(seen.compared, 1);
}

TEST(Inventory, NothingIsCalledInsideOfACall) {
  ObservedInventory seen;
  seen.inventory.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.events, IsEmpty());
  EXPECT_EQ(seen.compared, 0);
}

TEST(Inventory, AnEqualListIsDroppedAndOnlyChangedRecordsAreParsed) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}, {3, "fan"}}));
  const auto parsed = seen.inventory.counters().parsed;
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "plug"}, {3, "fan"}})), IsEmpty());
  EXPECT_EQ(seen.inventory.counters().repeated, 1U);
  EXPECT_EQ(seen.compared, 2);
  EXPECT_EQ(seen.inventory.counters().parsed, parsed);
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "socket"}, {3, "fan"}})), ElementsAre("changed 02: socket"));
  EXPECT_EQ(seen.inventory.counters().parsed, parsed + 1);
}

TEST(Inventory, ARecordThatDiffersInAnUnusedMemberChangesNothing) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  TestRecord moved{1, "lamp"};
  moved.more = R"(,"network_address":4711)";
  EXPECT_THAT(seen.list(list_of({moved})), IsEmpty());
}

/// Pitfall 4 of zigbee.md, section 12.
TEST(Inventory, Pitfall4ARenamedDeviceStaysTheSame) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  EXPECT_THAT(seen.list(list_of({{1, "hall/lamp"}, {2, "plug"}})), ElementsAre("changed 01: hall/lamp"));
  EXPECT_THAT(seen.list(list_of({{1, "plug"}, {2, "hall/lamp"}})),
              ElementsAre("changed 01: plug", "changed 02: hall/lamp"));
  EXPECT_EQ(seen.inventory.size(), 2U);
}

/// Pitfall 2: 300 devices make more than 1 MB.
TEST(Inventory, Pitfall2AListOfSeveralMegabytesIsTaken) {
  ObservedInventory seen;
  std::vector<TestRecord> records;
  for (unsigned i = 1; i <= 1000; ++i) {
    records.push_back({i, fmt::format("device {}", i)});
    records.back().more = fmt::format(R"(,"endpoints":{{"1":{{"scenes":[],"name":"{}"}}}})", std::string(3000, 'x'));
  }
  const auto list = list_of(records);
  ASSERT_GT(list.size(), 3'000'000U);
  EXPECT_EQ(seen.list(list).size(), 1000U);
  EXPECT_EQ(seen.inventory.size(), 1000U);
}

/// Pitfall 3: a mass join publishes four lists a device; only the newest of those that wait is compared.
TEST(Inventory, Pitfall3ABurstCostsOneListAtATime) {
  ObservedInventory seen;
  std::vector<TestRecord> records;
  for (unsigned i = 1; i <= 300; ++i) {
    records.push_back({i, fmt::format("device {}", i)});
    seen.inventory.list(list_of(records));
  }
  const auto events = seen.run();
  EXPECT_EQ(events.size(), 300U);
  EXPECT_EQ(seen.inventory.counters().compared, 1U);
  EXPECT_EQ(seen.inventory.counters().replaced, 299U);
  EXPECT_EQ(seen.inventory.counters().parsed, 301U);  // with the coordinator
}

TEST(Inventory, ATurnParsesAFewRecordsAndNewerListsWaitForTheEnd) {
  ObservedInventory seen;
  std::vector<TestRecord> records;
  for (unsigned i = 1; i <= 400; ++i) {
    records.push_back({i, fmt::format("device {}", i)});
    records.back().more = fmt::format(R"(,"unknown":"{}")", std::string(1000, 'x'));
  }
  const auto record_size = records[0].text().size();
  int turns = 0;
  std::size_t most_in_a_turn = 0;
  seen.inventory.list(list_of(records));
  std::function<void()> each_turn = [&] {
    most_in_a_turn = std::max(most_in_a_turn, seen.events.size());
    seen.events.clear();
    ++turns;
    if (seen.compared == 0) seen.scheduler.post(each_turn);
  };
  seen.scheduler.post(each_turn);
  seen.scheduler.run_ready();
  EXPECT_GT(turns, 10);
  EXPECT_LE(most_in_a_turn, Inventory::kParsedPerTurn / record_size + 2);
  EXPECT_LE(seen.inventory.counters().longest_turn, Inventory::kParsedPerTurn + record_size);
  EXPECT_EQ(seen.inventory.size(), 400U);
}

TEST(Inventory, AListThatArrivesWhileAnotherIsComparedIsTakenAfterIt) {
  ObservedInventory seen;
  std::vector<TestRecord> many;
  for (unsigned i = 1; i <= 200; ++i) many.push_back({i, fmt::format("device {}", i)});
  bool sent = false;
  const auto later = list_of({{1, "other"}});
  Inventory* inventory = nullptr;
  VirtualScheduler scheduler;
  int changed = 0;
  Inventory under_test(scheduler, 1000,
                       {[&](const auto&) {
                          ++changed;
                          if (!std::exchange(sent, true)) inventory->list(later);
                        },
                        [](const auto&, const auto&) {}, [](const auto&, const auto&) {}, [](const auto&) {}, [] {}});
  inventory = &under_test;
  under_test.list(list_of(many));
  scheduler.run_ready();
  EXPECT_EQ(changed, 201);
  EXPECT_EQ(under_test.find(test_address(1))->name, "other");
}

TEST(Inventory, DevicesOfOneModelKeepTheirDefinitionOnce) {
  ObservedInventory seen;
  seen.list(list_of({{1, "one"}, {2, "two"}, {3, "three"}}));
  const auto leaves_of = [&](unsigned device) { return seen.inventory.find(test_address(device))->leaves; };
  ASSERT_FALSE(leaves_of(1).empty());
  EXPECT_EQ(leaves_of(1).begin(), leaves_of(2).begin());
  EXPECT_EQ(leaves_of(1).begin(), leaves_of(3).begin());
}

std::vector<TestRecord> many_records(unsigned count) {
  std::vector<TestRecord> many;
  for (unsigned i = 1; i <= count; ++i) many.push_back({i, fmt::format("device {}", i)});
  return many;
}

TEST(Inventory, AListThatIsBackBeforeItWasComparedCountsOnce) {
  ObservedInventory seen;
  const auto list = list_of(many_records(400));
  seen.inventory.list(list);
  seen.on_first_call = [&] {
    seen.inventory.list(list_of({{1, "other"}}));
    seen.inventory.list(list);
  };
  EXPECT_EQ(seen.run().size(), 400U);
  EXPECT_EQ(seen.inventory.counters().compared, 1U);
  EXPECT_EQ(seen.inventory.counters().repeated, 1U);
  EXPECT_EQ(seen.compared, 2);
}

TEST(Inventory, ACallMayDestroyIt) {
  VirtualScheduler scheduler;
  std::unique_ptr<Inventory> inventory;
  int calls = 0;
  const auto destroy = [&] {
    ++calls;
    inventory.reset();
  };
  for (const auto& list : {list_of({{1, "a"}, {2, "b"}}), list_of({{1, "a", "FAILED"}}), std::string("[]"),
                           std::string("{"), list_of_texts({"{}"})}) {
    inventory = std::make_unique<Inventory>(
        scheduler, 10,
        Inventory::Callbacks{[&](const auto&) { destroy(); }, [&](const auto&, const auto&) { destroy(); },
                             [&](const auto&, const auto&) { destroy(); }, [&](const auto&) { destroy(); }, destroy});
    inventory->list(list);
    scheduler.run_ready();
    EXPECT_EQ(inventory, nullptr);
  }
  EXPECT_EQ(calls, 5);
}

TEST(Inventory, AnAbsentDeviceLeavesAfterTwoDifferentLists) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), IsEmpty());
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), IsEmpty()) << "the same list has nothing new";
  EXPECT_THAT(seen.list(list_of({{1, "light"}})), ElementsAre("changed 01: light", std::string("left 02: ") + kGone));
  EXPECT_EQ(seen.inventory.size(), 1U);
}

TEST(Inventory, AnAbsentDeviceLeavesAfterTenSeconds) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.run_for(9'999ms), IsEmpty());
  EXPECT_THAT(seen.run_for(1ms), ElementsAre(std::string("left 02: ") + kGone));
}

TEST(Inventory, ADeviceWhoseLeaveIsReportedIsGoneWithTheNextListThatLacksIt) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.inventory.leaving(test_address(2));
  EXPECT_THAT(seen.run_for(1min), IsEmpty()) << "the list is the truth";
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("left 02: left the ZigBee network"));
}

TEST(Inventory, AListFromBeforeTheReportDoesNotKeepADeviceThatLeaves) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.inventory.list(list_of({{1, "light"}, {2, "plug"}}));
  seen.inventory.leaving(test_address(2));
  EXPECT_THAT(seen.run(), ElementsAre("changed 01: light"));
  EXPECT_THAT(seen.list(list_of({{1, "light"}})), ElementsAre("left 02: left the ZigBee network"));
}

TEST(Inventory, ADeviceIsNotGoneWhileAListThatMayHaveItWaits) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.list(list_of({{1, "lamp"}}));
  seen.inventory.leaving(test_address(2));
  seen.inventory.list(list_of({{1, "lamp"}, {2, "plug"}}));
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
}

TEST(Inventory, ADeviceWhoseLeaveIsReportedAfterTheListIsGoneAtOnce) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.list(list_of({{1, "lamp"}}));
  seen.inventory.leaving(test_address(2));
  EXPECT_THAT(seen.run(), ElementsAre("left 02: left the ZigBee network"));
}

TEST(Inventory, ADeviceThatLeftAndIsBackStays) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.inventory.leaving(test_address(2));
  seen.list(list_of({{1, "light"}, {2, "plug"}}));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), ElementsAre("changed 01: lamp"));
  EXPECT_THAT(seen.run_for(5s), IsEmpty());
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "plug"}})), IsEmpty());
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
}

TEST(Inventory, ADeviceThatLeftJoinsAgainWithTheSameRecord) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.inventory.leaving(test_address(2));
  seen.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}, {2, "plug"}})), ElementsAre("changed 02: plug"));
}

/// Pitfall 16: lists that are short, empty or missing while the bridge starts or interviews.
TEST(Inventory, Pitfall16AShortListDropsNoDevice) {
  ObservedInventory seen;
  const auto whole = list_of({{1, "lamp"}, {2, "plug"}, {3, "fan"}});
  seen.list(whole);
  EXPECT_THAT(seen.list(list_of({{3, "fan"}})), IsEmpty());
  EXPECT_THAT(seen.run_for(3s), IsEmpty());
  EXPECT_THAT(seen.list(whole), IsEmpty());
  EXPECT_THAT(seen.list("[]"), IsEmpty());
  EXPECT_THAT(seen.run_for(3s), IsEmpty());
  EXPECT_THAT(seen.list(whole), IsEmpty());
  EXPECT_THAT(seen.run_for(1min), IsEmpty());
  EXPECT_EQ(seen.inventory.size(), 3U);
}

TEST(Inventory, Pitfall16AMissingListDropsNoDevice) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}}));
  EXPECT_THAT(seen.list(""), IsEmpty()) << "the broker lost its retained messages";
  EXPECT_THAT(seen.run_for(24h), IsEmpty());
  EXPECT_EQ(seen.inventory.size(), 1U);
}

TEST(Inventory, AnEmptyListThatStaysDropsAllDevices) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.list("[]");
  EXPECT_EQ(seen.run_for(10s).size(), 2U);
}

TEST(Inventory, ALostLineKeepsTheDevicesAndTheNextListCountsAnew) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.list(list_of({{1, "lamp"}}));
  seen.inventory.line_lost();
  EXPECT_THAT(seen.run_for(1h), IsEmpty());
  EXPECT_THAT(seen.list(list_of({{1, "lamp"}})), IsEmpty());
  EXPECT_THAT(seen.run_for(10s), ElementsAre(std::string("left 02: ") + kGone));
}

/// It has 399 of 400 known devices, all with other names, and is not compared yet.
std::string send_long_list_of_changes(ObservedInventory& seen) {
  auto records = many_records(400);
  seen.list(list_of(records));
  records.pop_back();
  for (auto& record : records) record.name += " renamed";
  const auto list = list_of(records);
  seen.inventory.list(list);
  return list;
}

TEST(Inventory, AListThatIsComparedWhenTheLineIsLostDropsNoDevice) {
  ObservedInventory seen;
  const auto list = send_long_list_of_changes(seen);
  seen.on_first_call = [&] { seen.inventory.line_lost(); };
  EXPECT_EQ(seen.run_for(1h).size(), 399U);
  EXPECT_THAT(seen.list(list), IsEmpty());
  EXPECT_EQ(seen.run_for(10s).size(), 1U) << "the same list counts anew";
}

TEST(Inventory, TheSameListAfterTheLineIsLostCountsAlsoBeforeItWasCompared) {
  ObservedInventory seen;
  const auto list = send_long_list_of_changes(seen);
  seen.on_first_call = [&] {
    seen.inventory.line_lost();
    seen.inventory.list(list);
  };
  EXPECT_EQ(seen.run().size(), 399U);
  EXPECT_EQ(seen.run_for(10s).size(), 1U);
}

TEST(Inventory, AListThatTheLineInterruptsDropsNoDevice) {
  ObservedInventory seen;
  seen.list(list_of({{1, "lamp"}, {2, "plug"}}));
  seen.inventory.list("[]");
  seen.inventory.line_lost();
  EXPECT_THAT(seen.run_for(1h), IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
