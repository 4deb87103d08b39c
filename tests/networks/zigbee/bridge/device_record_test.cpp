#include <gmock/gmock.h>

#include "networks/zigbee/bridge/bridge_lists.h"
#include "networks/zigbee/bridge/settings.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

DeviceRecord read(const TestRecord& record) {
  auto read = read_device_record(record.text());
  EXPECT_TRUE(read) << (read ? "" : read.error().text);
  return read ? *read : DeviceRecord{};
}

TEST(DeviceRecord, AbsentNullAndUnknownMembersAreAlike) {
  const auto least = R"({"ieee_address":"0x00124B0000000001","friendly_name":"x")";
  const auto absent = read_device_record(std::string(least) + "}");
  const auto null =
      read_device_record(std::string(least) + R"(,"definition":null,"type":null,"power_source":null,"endpoints":null,)"
                                              R"("supported":null,"disabled":null,"unknown":{"a":[1,2]}})");
  ASSERT_TRUE(absent);
  ASSERT_TRUE(null);
  EXPECT_EQ(*absent, *null);
  EXPECT_EQ(absent->address, "00124b0000000001");
  EXPECT_EQ(absent->role, Role::kUnknown);
  EXPECT_FALSE(absent->supported);
  EXPECT_EQ(ieee_of(absent->address), "0x00124b0000000001");
}

TEST(DeviceRecord, MembersOfWrongKindsAreAsAbsent) {
  const auto record = read_device_record(
      R"({"ieee_address":"0x00124b0000000001","friendly_name":"x","type":7,"supported":"yes","disabled":1,)"
      R"("power_source":[],"interview_state":{},"interviewing":"no","endpoints":[1],"model_id":5})");
  ASSERT_TRUE(record) << record.error().text;
  EXPECT_EQ(record->interview, Interview::kPending);
  EXPECT_EQ(record->model, "");
}

TEST(DeviceRecord, WithoutAnAddressItCannotBeRead) {
  for (const auto* text :
       {"", "17", "[]", "{}", R"({"ieee_address":"00124b0000000001","friendly_name":"x"})",
        R"({"ieee_address":"0x00124b000000000g","friendly_name":"x"})",
        R"({"ieee_address":"0x00124b00000000010","friendly_name":"x"})", R"({"ieee_address":5,"friendly_name":"x"})",
        R"({"ieee_address":"0x00124b0000000001","friendly_name":"x","definition":{"exposes":7}})"}) {
    const auto record = read_device_record(text);
    ASSERT_FALSE(record) << text;
    EXPECT_EQ(record.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(record.error().text, HasSubstr("device"));
  }
}

TEST(DeviceRecord, ANameThatNoTopicCanHaveMakesItWait) {
  for (const auto* name : {R"("")", R"("a#")", R"("+a")", R"("/a")", R"("a\n")", "7", "null"}) {
    const auto record = read_device_record(
        fmt::format(R"({{"ieee_address":"0x00124b0000000001","interview_state":"SUCCESSFUL","supported":true,)"
                    R"("friendly_name":{}}})",
                    name));
    ASSERT_TRUE(record) << name;
    EXPECT_NE(record->unusable_name, "") << name;
    EXPECT_THAT(why_waiting(*record), HasSubstr("rubicon zigbee rename 00124b0000000001 NAME")) << name;
  }
}

TEST(DeviceRecord, NamesHaveSlashesBlanksAndUtf8AndAreBounded) {
  EXPECT_EQ(name_problem("Küche/lamp 1"), "");
  EXPECT_EQ(name_problem(std::string(512, 'x')), "");
  EXPECT_THAT(name_problem(std::string(513, 'x')), HasSubstr("512 bytes"));
  EXPECT_THAT(name_problem("\xff"), HasSubstr("UTF-8"));
  for (const auto* refused : {"a\xc2\x85", "a\x7f", "a\n", "a\xef\xbf\xbf", "a\xef\xb7\x90"})
    EXPECT_THAT(name_problem(refused), HasSubstr("control characters or noncharacters")) << refused;
  EXPECT_THAT(name_problem(std::string(90, '/') + "a"), HasSubstr("more than 90 levels"));
  EXPECT_EQ(name_problem("a" + std::string(89, '/') + "a"), "");
  TestRecord record;
  record.name = std::string(300'000, 'x');
  EXPECT_FALSE(read_device_record(record.text()));
}

TEST(DeviceRecord, OlderBridgesHaveTwoBooleansForTheInterview) {
  const auto interview = [](const char* members) {
    const auto record =
        read_device_record(fmt::format(R"({{"ieee_address":"0x00124b0000000001","friendly_name":"x",{}}})", members));
    return record ? record->interview : Interview::kPending;
  };
  EXPECT_EQ(interview(R"("interviewing":true,"interview_completed":false)"), Interview::kInProgress);
  EXPECT_EQ(interview(R"("interviewing":false,"interview_completed":true)"), Interview::kSuccessful);
  EXPECT_EQ(interview(R"("interviewing":false,"interview_completed":false)"), Interview::kPending);
  EXPECT_EQ(interview(R"("interview_completed":true,"interview_state":"FAILED")"), Interview::kFailed);
  EXPECT_EQ(interview(R"("interview_state":"SOMETHING_NEW")"), Interview::kPending);
}

TEST(DeviceRecord, TheUsersDescriptionGoesBeforeThatOfTheModel) {
  EXPECT_EQ(read({}).description, "D");
  TestRecord described;
  described.more = R"(,"description":"Under the roof")";
  EXPECT_EQ(read(described).description, "Under the roof");
}

TEST(DeviceRecord, WithoutADefinitionTheDevicesOwnWordsNameTheModel) {
  TestRecord record;
  record.exposes = "";
  record.more = R"(,"manufacturer":"_TZ3000_abc","model_id":"TS0001")";
  record.supported = false;
  const auto read_record = read(record);
  EXPECT_EQ(read_record.vendor, "_TZ3000_abc");
  EXPECT_EQ(read_record.model, "TS0001");
  EXPECT_THAT(why_waiting(read_record), HasSubstr("'TS0001' of '_TZ3000_abc'"));
}

TEST(DeviceRecord, MainsIsAKnownSourceOrARouter) {
  const auto mains = [](const char* type, const char* power) {
    TestRecord record;
    record.type = type;
    record.power = power;
    return read(record).mains();
  };
  EXPECT_TRUE(mains("Router", ""));
  EXPECT_TRUE(mains("Router", "Unknown"));
  EXPECT_TRUE(mains("EndDevice", "DC Source"));
  EXPECT_TRUE(mains("EndDevice", "Mains (single phase)"));
  EXPECT_FALSE(mains("Router", "Battery"));
  EXPECT_FALSE(mains("EndDevice", "Battery"));
  EXPECT_FALSE(mains("EndDevice", ""));
  EXPECT_FALSE(mains("GreenPower", ""));
  EXPECT_FALSE(mains("Unknown", ""));
}

TestRecord reporting_every(const char* seconds) {
  TestRecord record;
  record.more =
      fmt::format(R"(,"endpoints":{{"1":{{"configured_reportings":[{{"cluster":"genOnOff","attribute":16384,)"
                  R"("minimum_report_interval":10,"maximum_report_interval":{}}},"nonsense"]}},"2":{{}},"3":null}})",
                  seconds);
  return record;
}

TEST(Liveness, MainsPoweredDevicesMayMissTwoReportsAndAtLeastAnHour) {
  EXPECT_EQ(silence_limit(read(reporting_every("300"))), Duration(1h));
  EXPECT_EQ(silence_limit(read(reporting_every("3600"))), Duration(3h));
  EXPECT_EQ(silence_limit(read(reporting_every("65000"))), Duration(3 * 65000s));
  EXPECT_EQ(silence_limit(read({})), Duration(1h));
  EXPECT_EQ(read(reporting_every("300")).reportings[0].attribute, "16384");
}

TEST(Liveness, AnIntervalThatMeansNeverIsNone) {
  for (const auto* seconds : {"0", "65535", "-1", "1e9", "99999999999999", "null"}) {
    EXPECT_EQ(longest_reporting(read(reporting_every(seconds))), Duration(0)) << seconds;
    EXPECT_EQ(silence_limit(read(reporting_every(seconds))), Duration(1h)) << seconds;
  }
}

TEST(Liveness, BatteryDevicesMayBeSilentForADayAndGroupsForEver) {
  auto sleeper = reporting_every("65000");
  sleeper.power = "Battery";
  EXPECT_EQ(silence_limit(read(sleeper)), Duration(25h));
  DeviceRecord group;
  group.address = "group-7";
  EXPECT_EQ(silence_limit(group), std::nullopt);
}

TEST(Liveness, TheBridgeDecidesWhereItPublishesAvailability) {
  BridgeDescription bridge;
  const auto record = read({});
  EXPECT_FALSE(bridge_decides(bridge, record));
  bridge.availability_enabled = true;
  EXPECT_TRUE(bridge_decides(bridge, record));
  bridge.of[record.address].availability = false;
  EXPECT_FALSE(bridge_decides(bridge, record));
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
