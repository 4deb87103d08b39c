#include "state/state_store.h"

#include <gmock/gmock.h>

#include <limits>

#include "state/crashing_disk.h"
#include "state/state_support.h"

namespace rubicon::state {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> addresses(const StateStore& store, const std::string& network = "") {
  std::vector<std::string> out;
  EXPECT_TRUE(store.each(network, [&](StateStore::Row, KnownDevice&& device) { out.push_back(device.address); }));
  return out;
}

TEST(StateStore, RemembersADeviceWithAllThereIsToItOverARestart) {
  Folder folder;
  auto device = device_of("wsn-1", "7");
  device.decision = Decision::kIgnored;
  device.join.heard = false;
  auto& capability = device.join.capabilities[0];
  capability.access = model::Access::kReadWrite;
  capability.maximum = 125;
  capability.reports = false;
  capability.initial = std::string("x");
  capability.type_name = "foreign";
  device.first_seen = at(3);
  device.last_heard = at(5);
  device.values = {value_at({Kind::kSensor, TypeId(1), "1"}, 21.5, 4),
                   value_at({Kind::kSensor, TypeId(1), "2"}, {}, 4),
                   value_at({Kind::kSensor, TypeId(2), "a"}, true, 4),
                   value_at({Kind::kActuator, TypeId(3), "1"}, std::int64_t{-7}, 4),
                   value_at({Kind::kProperty, TypeId(4), ""}, std::string("a\0b", 3), 4),
                   value_at({Kind::kProperty, TypeId(4), "light-1"}, model::Json{R"({"a":1})"}, 4)};
  device.values[3].user_time = at(1);
  device.values[4].set_by_user = true;
  device.values[4].heard = {};
  ASSERT_TRUE(opened(folder / "s")->save(device));
  const auto store = opened(folder / "s");
  const auto back = store->find("wsn-1", "7");
  ASSERT_TRUE(back && *back);
  EXPECT_EQ(text_of(**back), text_of(device));
  EXPECT_EQ((**back).values, device.values);
  EXPECT_EQ(snapshot(*store), text_of(device) + "\n");
}

TEST(StateStore, AnswersNothingForADeviceItDoesNotKnow) {
  Folder folder;
  const auto store = opened(folder / "s");
  const auto found = store->find("wsn-1", "7");
  ASSERT_TRUE(found);
  EXPECT_FALSE(*found);
}

TEST(StateStore, KeepsValuesAndFirstSeenWhenADeviceIsSavedAgain) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.values = {value_at(sensor(1), 20.0, 1)};
  const auto row = *store->save(device);
  device.values = {value_at(sensor(2), 99.0, 1)};
  device.first_seen = device.last_heard = at(100);
  device.id = "kitchen";
  device.decision = Decision::kApproved;
  device.join.name = "Kitchen";
  device.join.capabilities.pop_back();
  device.point_ids.pop_back();
  EXPECT_EQ(*store->save(device), row);
  auto expected = device;
  expected.first_seen = at(0);
  expected.values = {value_at(sensor(1), 20.0, 1)};
  EXPECT_EQ(text_of(**store->find("wsn-1", "7")), text_of(expected));
}

TEST(StateStore, KeepsANameAUserGaveUntilTheUserTakesItAway) {
  Folder folder;
  const auto row = *opened(folder / "s")->save(device_of("wsn-1", "7"));
  ASSERT_TRUE(opened(folder / "s")->rename(row, "Kitchen mote", "Kitchen"));
  const auto store = opened(folder / "s");
  ASSERT_TRUE(store->save(device_of("wsn-1", "7")));
  EXPECT_EQ((*store->find("wsn-1", "7"))->given_name, "Kitchen mote");
  EXPECT_EQ((*store->find("wsn-1", "7"))->area, "Kitchen");
  ASSERT_TRUE(store->rename(row, "", "Kitchen"));
  EXPECT_EQ((*store->find("wsn-1", "7"))->given_name, "");
  EXPECT_EQ((*store->find("wsn-1", "7"))->area, "Kitchen");
  EXPECT_EQ(store->rename(99, "x", "").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store->rename(row, std::string(kMaxGiven + 1, 'x'), "").error().code, ErrorCode::kOutOfRange);
}

TEST(StateStore, FillsInWhenADeviceOfTheConfigurationWasFirstSeen) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.first_seen = device.last_heard = {};
  ASSERT_TRUE(store->save(device));
  device.first_seen = at(9);
  ASSERT_TRUE(store->save(device));
  EXPECT_EQ((**store->find("wsn-1", "7")).first_seen, at(9));
}

TEST(StateStore, ReplacesTheValuesOfThesePointsAndKeepsTheOthers) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.values = {value_at(sensor(1), 20.0, 1), value_at(sensor(2), 40.0, 1)};
  const auto row = *store->save(device);
  const std::vector<StoredValue> news{value_at(sensor(2), std::string("wet"), 8),
                                      value_at(sensor(3), std::int64_t{4}, 7)};
  ASSERT_TRUE(store->save_values(row, news));
  const auto back = **store->find("wsn-1", "7");
  EXPECT_THAT(back.values, ElementsAre(device.values[0], news[0], news[1]));
  EXPECT_EQ(back.last_heard, at(8));
  EXPECT_EQ(store->stats().values, 3U);
}

TEST(StateStore, NeverMovesLastHeardBackByAValue) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.last_heard = at(10);
  const auto row = *store->save(device);
  ASSERT_TRUE(store->save_values(row, std::vector{value_at(sensor(1), 1.0, 5)}));
  auto by_user = value_at(sensor(2), 1.0, 5);
  by_user.heard = {};
  ASSERT_TRUE(store->save_values(row, std::vector{by_user}));
  EXPECT_EQ((**store->find("wsn-1", "7")).last_heard, at(10));
}

TEST(StateStore, KeepsANumberThatIsNoneAsNothing) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.values = {value_at(sensor(1), std::numeric_limits<double>::quiet_NaN(), 1),
                   value_at(sensor(2), std::numeric_limits<double>::infinity(), 1)};
  ASSERT_TRUE(store->save(device));
  const auto back = **store->find("wsn-1", "7");
  ASSERT_EQ(back.values.size(), 2U);
  for (const auto& value : back.values) EXPECT_EQ(value.value, model::Value{});
}

TEST(StateStore, GivesDevicesInTheOrderTheyWereFirstSaved) {
  Folder folder;
  const auto store = opened(folder / "s");
  for (const auto* address : {"9", "1", "5"}) ASSERT_TRUE(store->save(device_of("wsn-1", address)));
  ASSERT_TRUE(store->save(device_of("knx", "1.4.6")));
  ASSERT_TRUE(store->save(device_of("wsn-1", "1")));
  EXPECT_THAT(addresses(*store), ElementsAre("9", "1", "5", "1.4.6"));
  EXPECT_THAT(addresses(*store, "wsn-1"), ElementsAre("9", "1", "5"));
  EXPECT_THAT(addresses(*store, "wsn-2"), ElementsAre());
}

TEST(StateStore, LetsAVisitorWriteAndVisitsOnlyWhatWasThere) {
  Folder folder;
  const auto store = opened(folder / "s");
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(store->save(device_of("wsn-1", std::to_string(i))));
  int visits = 0;
  ASSERT_TRUE(store->each("", [&](StateStore::Row row, KnownDevice&& device) {
    ++visits;
    EXPECT_TRUE(store->save(device_of("wsn-2", device.address)));
    EXPECT_TRUE(store->save_values(row, std::vector{value_at(sensor(1), 1.0, 5)}));
    EXPECT_EQ(addresses(*store, "wsn-1").size(), 5U);
    if (device.address == "2") {
      EXPECT_TRUE(store->forget("wsn-2", "2"));
    }
  }));
  EXPECT_EQ(visits, 5);
  EXPECT_EQ(store->stats().devices, 9U);
}

TEST(StateStore, ForgetsADeviceAndNeverGivesItsRowToAnother) {
  Folder folder;
  auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "7");
  device.values = {value_at(sensor(1), 20.0, 1)};
  const auto row = *store->save(device);
  ASSERT_TRUE(store->forget("wsn-1", "7"));
  EXPECT_EQ(store->forget("wsn-1", "7").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store->stats().devices, 0U);
  EXPECT_EQ(store->stats().values, 0U);
  EXPECT_NE(*store->save(device_of("wsn-1", "8")), row);
  store.reset();
  store = opened(folder / "s");
  EXPECT_NE(*store->save(device_of("wsn-1", "9")), row);
  const std::vector<StoredValue> late{value_at(sensor(1), 1.0, 5)};
  EXPECT_EQ(store->save_values(row, late).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store->save_values(row, {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store->stats().values, 0U);
}

TEST(StateStore, TakesATransactionAsAWhole) {
  Folder folder;
  auto store = opened(folder / "s");
  ASSERT_TRUE(store->save(device_of("wsn-1", "0")));
  const auto before = snapshot(*store);
  ASSERT_TRUE(store->begin());
  ASSERT_TRUE(store->save(device_of("wsn-1", "1")));
  ASSERT_TRUE(store->forget("wsn-1", "0"));
  EXPECT_EQ(store->forget("wsn-1", "none").error().code, ErrorCode::kNotFound);
  store->rollback();
  EXPECT_EQ(snapshot(*store), before);
  EXPECT_EQ(store->stats().devices, 1U);
  ASSERT_TRUE(store->begin());
  ASSERT_TRUE(store->save(device_of("wsn-1", "2")));
  EXPECT_EQ(store->forget("wsn-1", "none").error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(store->commit(true));
  ASSERT_TRUE(store->begin());
  ASSERT_TRUE(store->save(device_of("wsn-1", "3")));
  store.reset();  // dies in a transaction
  EXPECT_THAT(addresses(*opened(folder / "s")), ElementsAre("0", "2"));
}

TEST(StateStore, RefusesWhatItCouldNotReadBackAndGoesOn) {
  Folder folder;
  const auto store = opened(folder / "s");
  ASSERT_TRUE(store->begin());
  auto device = device_of("wsn-1", std::string(256, 'x'));
  EXPECT_EQ(store->save(device).error().code, ErrorCode::kOutOfRange);
  device = device_of("wsn-1", "1");
  device.join.capabilities[0].unit = std::string(256, 'x');
  const auto refused = store->save(device);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfRange);
  EXPECT_THAT(refused.error().text, HasSubstr("wsn-1/1"));
  EXPECT_THAT(refused.error().text, HasSubstr("unit"));
  device = device_of("wsn-1", "1");
  device.join.capabilities.resize(5000, device.join.capabilities[0]);
  EXPECT_EQ(store->save(device).error().code, ErrorCode::kOutOfRange);
  const auto row = *store->save(device_of("wsn-1", "2"));
  const std::vector<StoredValue> big{value_at(sensor(1), 1.0, 1),
                                     value_at(sensor(2), std::string(kMaxStoredValue + 1, 'x'), 1)};
  EXPECT_EQ(store->save_values(row, big).error().code, ErrorCode::kOutOfRange);
  ASSERT_TRUE(store->commit(false));
  EXPECT_THAT(addresses(*store), ElementsAre("2"));
  EXPECT_EQ(store->stats().values, 0U);
  EXPECT_EQ(store->stats().failures, 4U);
}

TEST(StateStore, KeepsTextThatIsNoUtf8) {
  Folder folder;
  const auto store = opened(folder / "s");
  auto device = device_of("wsn-1", "\xff\xfe");
  device.join.name = std::string("a\0\x80", 3);
  device.values = {value_at(sensor(1), std::string("\xc3"), 0)};
  ASSERT_TRUE(store->save(device));
  EXPECT_EQ(text_of(**store->find("wsn-1", "\xff\xfe")), text_of(device));
}

TEST(StateStore, StaysBelowItsBoundByForgettingWhatWasNotHeardForLongest) {
  Folder folder;
  StateOptions options;
  options.max_bytes = 512 << 10;
  auto store = opened(folder / "s", options);
  auto decided = device_of("wsn-1", "old-but-decided");
  decided.decision = Decision::kApproved;
  decided.last_heard = at(-1000);
  ASSERT_TRUE(store->save(decided));
  constexpr int kDevices = 2000;
  for (int i = 0; i < kDevices; ++i) {
    auto device = device_of("wsn-1", std::to_string(i));
    device.last_heard = at(i);
    device.values = {value_at(sensor(1), std::string(100, 'x'), i)};
    ASSERT_TRUE(store->save(device));
    ASSERT_LE(store->stats().bytes, options.max_bytes);
  }
  const auto left = addresses(*store);
  EXPECT_EQ(left.front(), "old-but-decided");
  EXPECT_EQ(left.back(), std::to_string(kDevices - 1));
  // The youngest, without a gap.
  for (std::size_t i = 1; i < left.size(); ++i) EXPECT_EQ(left[left.size() - i], std::to_string(kDevices - int(i)));
  EXPECT_GT(left.size(), 100U);
  EXPECT_EQ(store->stats().pruned + left.size(), kDevices + 1U);
  EXPECT_EQ(store->stats().devices, left.size());
  store.reset();
  EXPECT_LE(std::filesystem::file_size(folder / "s"), options.max_bytes);
  EXPECT_EQ(opened(folder / "s", options)->stats().values, left.size() - 1);
}

TEST(StateStore, SaysSoWhenOneDeviceAloneIsBeyondTheBoundAndGoesOn) {
  Folder folder;
  StateOptions options;
  options.max_bytes = 256 << 10;
  const auto store = opened(folder / "s", options);
  const auto row = *store->save(device_of("wsn-1", "1"));
  std::vector<StoredValue> big;
  for (int i = 0; i < 5; ++i) big.push_back(value_at(sensor(1, std::to_string(i)), std::string(60 << 10, 'x'), 1));
  const auto refused = store->save_values(row, big);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, HasSubstr("limited to"));
  EXPECT_TRUE(store->save_values(row, std::vector{value_at(sensor(1), 1.0, 1)}));
}

TEST(StateStore, DoesNotRecountWhatATransactionTookBack) {
  Folder folder;
  StateOptions options;
  options.max_bytes = 256 << 10;
  const auto store = opened(folder / "s", options);
  ASSERT_TRUE(store->begin());
  for (int i = 0; i < 800; ++i) ASSERT_TRUE(store->save(device_of("wsn-1", std::to_string(i))));
  EXPECT_GT(store->stats().pruned, 0U);
  store->rollback();
  EXPECT_EQ(store->stats().pruned, 0U);
  EXPECT_EQ(store->stats().devices, 0U);
}

/// A store of before: it knows the number 0x0400 and keys by the name of before.
TEST(StateStore, AFileOfFormerTypesIsReadWithThoseOfToday) {
  Folder folder;
  auto device = device_of("dummy-1", "living");
  device.join.capabilities[0].point = {Kind::kSensor, TypeId(0x0400), "1"};
  device.join.capabilities[0].type_name = "illuminance";
  device.point_ids = {{{Kind::kSensor, TypeId(0x0400), "1"}, "illuminance-window"}};
  device.values = {value_at({Kind::kSensor, TypeId(0x0400), "1"}, 52.5, 4),
                   value_at({Kind::kSensor, TypeId(0x0202), "1"}, true, 4),
                   value_at({Kind::kProperty, TypeId(0x0603), "pir-1"}, 7.5, 4)};
  device.values[2].set_by_user = true;
  ASSERT_TRUE(opened(folder / "s")->save(device));
  const auto expect_today = [](const StateStore& store, double light) {
    const auto back = store.find("dummy-1", "living");
    ASSERT_TRUE(back && *back);
    const auto& known = **back;
    EXPECT_EQ(known.join.capabilities[0].point, sensor(1));
    EXPECT_EQ(known.join.capabilities[0].type_name, "light");
    ASSERT_EQ(known.point_ids.size(), 1U);
    EXPECT_EQ(known.point_ids[0], (std::pair(sensor(1), std::string("light-window"))));
    ASSERT_EQ(known.values.size(), 3U);
    for (const auto& value : known.values) {
      if (value.point == sensor(1)) {
        EXPECT_EQ(value.value, model::Value(light));
      }
      if (value.point == sensor(10)) {
        EXPECT_EQ(value.value, model::Value(true));
      }
      if (value.point.kind != Kind::kProperty) continue;
      EXPECT_EQ(value.point.instance, "motion-1");
      EXPECT_EQ(value.value, model::Value(7.5));
      EXPECT_TRUE(value.set_by_user);
    }
  };
  expect_today(**StateStore::open_existing(folder / "s", StateStore::Use::kRead), 52.5);
  const auto store = opened(folder / "s");
  expect_today(*store, 52.5);
  const auto values = std::vector{value_at(sensor(1), 60.5, 9)};
  device.values.clear();
  const auto row = store->save(device);
  ASSERT_TRUE(row);
  ASSERT_TRUE(store->save_values(*row, values));
  expect_today(*store, 60.5);
}

TEST(StateStore, RemembersSmallValuesOfNetworks) {
  Folder folder;
  {
    const auto store = opened(folder / "s");
    EXPECT_EQ(*store->remembered("knx", "sequence"), std::nullopt);
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{1, 2}, 2));
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{0}, 2));
    ASSERT_TRUE(store->remember("knx-2", "sequence", Bytes{9}, 2));
    ASSERT_TRUE(store->remember("knx", "timer", Bytes{7}, 2));
    const auto full = store->remember("knx", "one-too-many", Bytes{7}, 2);
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().code, ErrorCode::kBusy);
    EXPECT_THAT(full.error().text, testing::HasSubstr("network knx remembers 2 values"));
    ASSERT_TRUE(store->remember("knx", "timer", {}, 2));
    ASSERT_TRUE(store->remember("knx", "never-there", {}, 2));
  }
  const auto store = opened(folder / "s");
  EXPECT_EQ(*store->remembered("knx", "sequence"), Bytes{0});
  EXPECT_EQ(*store->remembered("knx-2", "sequence"), Bytes{9});
  EXPECT_EQ(*store->remembered("knx", "timer"), std::nullopt);
}

TEST(StateStore, WaitsForTheDiskOnlyForDurableValues) {
  Folder folder;
  install_crashing_disk({});
  {
    const auto store = opened(folder / "s");
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{1}, 9));
    const auto begin = disk_operations();
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{2}, 9, false));
    const auto middle = disk_operations();
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{3}, 9, true));
    EXPECT_LT(middle - begin, disk_operations() - middle);
  }
  remove_crashing_disk();
  EXPECT_EQ(*opened(folder / "s")->remembered("knx", "sequence"), Bytes{3});
}

/// A value that only changes needs no room.
TEST(StateStore, ForgetsNoDeviceForAValueThatIsReplaced) {
  Folder folder;
  StateOptions options;
  options.max_bytes = 256 << 10;
  const auto store = opened(folder / "s", options);
  ASSERT_TRUE(store->remember("knx", "sequence", Bytes{1}, 9));
  for (int i = 0; i < 1000; ++i) {
    auto device = device_of("wsn-1", std::to_string(i));
    device.last_heard = at(i);
    device.values = {value_at(sensor(1), std::string(100, 'x'), i)};
    ASSERT_TRUE(store->save(device));
    const auto pruned = store->stats().pruned;
    ASSERT_TRUE(store->remember("knx", "sequence", Bytes{static_cast<std::uint8_t>(i)}, 9, false));
    ASSERT_EQ(store->stats().pruned, pruned);
  }
  EXPECT_GT(store->stats().pruned, 0U);
}

TEST(StateStore, ThatIsReadOnlyRemembersNothingNew) {
  Folder folder;
  ASSERT_TRUE(opened(folder / "s")->remember("knx", "sequence", Bytes{1}, 9));
  const auto store = StateStore::open_existing(folder / "s", StateStore::Use::kRead).value();
  EXPECT_EQ(store->remember("knx", "sequence", Bytes{2}, 9).error().code, ErrorCode::kRefused);
  EXPECT_EQ(*store->remembered("knx", "sequence"), Bytes{1});
}

}  // namespace
}  // namespace rubicon::state
