#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/completion.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/woken.h"

namespace rubicon::cli {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

std::string long_text(std::string_view text, std::string_view last) {
  const auto typed = parse_target(text);
  const auto pattern = typed ? long_form(*typed, last) : std::nullopt;
  return pattern ? to_string(*pattern) : "";
}

TEST(CliNames, ShortNamesStandForPoints) {
  EXPECT_EQ(long_text("living.lamp-1", "command"), "*.*.living.*.lamp-1.command");
  EXPECT_EQ(long_text("7:dummy-1.living.lamp-1", "value"), "7:*.dummy-1.living.*.lamp-1.value");
  EXPECT_EQ(long_text("proxy.dummy-1.living.actuator.lamp-1", "command"),
            "proxy.dummy-1.living.actuator.lamp-1.command");
  EXPECT_EQ(long_text("proxy.dummy-1.living.actuator.lamp-1.value", "command"), "");
  EXPECT_EQ(long_text("robot.arm.joint.three.angle", "value"), "");
  EXPECT_EQ(long_text("GATEWAY", "value"), "");
}

TEST(CliNames, ATargetIsOneTupleWithOrWithoutItsOwner) {
  const auto typed = parse_target("6541:proxy.networks");
  ASSERT_TRUE(typed);
  EXPECT_EQ(typed->owner, OwnerId(6541));
  EXPECT_EQ(typed->key, "proxy.networks");
  EXPECT_FALSE(parse_target("proxy.*.status"));
  EXPECT_FALSE(parse_target("a..b"));
  EXPECT_FALSE(parse_target(""));
}

TEST(CliNames, APatternWithoutWildcardsIsAlsoTriedAsAShortName) {
  const auto both = parse_patterns("living.lamp-1", "value");
  ASSERT_TRUE(both);
  ASSERT_EQ(both->size(), 2U);
  EXPECT_EQ(to_string(both->at(0)), "living.lamp-1");
  EXPECT_EQ(to_string(both->at(1)), "*.*.living.*.lamp-1.value");
  EXPECT_EQ(parse_patterns("proxy.**", "value")->size(), 1U);
  EXPECT_FALSE(parse_patterns("proxy.**.x", "value"));
}

client::Device device(std::uint32_t island, std::string network, std::string id, std::string name) {
  client::Device one;
  one.island = OwnerId(island);
  one.prefix = "proxy";
  one.network = std::move(network);
  one.id = std::move(id);
  one.name = std::move(name);
  one.address = one.id;
  one.sensors = {"light-1"};
  return one;
}

std::vector<client::Device> some_devices() {
  return {device(1, "wsn", "7", "Kitchen mote"), device(2, "wsn", "7", "Hall mote"), device(2, "knx", "hall", "7")};
}

TEST(CliNames, ADeviceIsCalledByKeyOrByName) {
  const auto all = some_devices();
  EXPECT_EQ(devices_called(all, "7").size(), 2U);
  EXPECT_EQ(devices_called(all, "1:7").size(), 1U);
  EXPECT_EQ(devices_called(all, "knx.hall").size(), 1U);
  EXPECT_EQ(devices_called(all, "2:proxy.wsn.7").at(0).name, "Hall mote");
  EXPECT_EQ(devices_called(all, "Kitchen mote").at(0).island, OwnerId(1));
  EXPECT_THAT(devices_called(all, "nobody"), IsEmpty());
}

TEST(CliNames, CountsTheDevicesThatAPatternWakes) {
  const auto all = some_devices();
  const auto woken = [&](const char* text) { return woken_devices(all, {Pattern::parse(text).value()}); };
  EXPECT_EQ(woken("proxy.**"), 3U);
  EXPECT_EQ(woken("2:proxy.*.*.sensor.*.value"), 2U);
  EXPECT_EQ(woken("proxy.wsn.7.sensor.light-1.value"), 2U);
  EXPECT_EQ(woken("proxy.*.*.status"), 0U);
  EXPECT_EQ(woken("proxy.*.*.actuator.*.value"), 0U);
}

TEST(CliCompletion, OffersCommandsOptionsAndActions) {
  Cli cli;
  EXPECT_THAT(fixed_offers(cli.app(), {}, "w"), Contains("watch"));
  EXPECT_THAT(fixed_offers(cli.app(), {}, ""), Not(Contains("complete")));
  EXPECT_THAT(fixed_offers(cli.app(), {"watch"}, "--"), Contains("--dead-band"));
  EXPECT_THAT(fixed_offers(cli.app(), {"watch"}, "--"), Contains("--domain"));
  EXPECT_THAT(fixed_offers(cli.app(), {"inbox"}, ""), Contains("approve"));
  EXPECT_THAT(fixed_offers(cli.app(), {"--domain"}, ""), IsEmpty());
  EXPECT_THAT(fixed_offers(cli.app(), {"--json"}, ""), Contains("ls"));
}

TEST(CliCompletion, AsksTheIslandsOnlyForWhatMayFollow) {
  EXPECT_EQ(wanted_at({"get"}), Wanted::kTuple);
  EXPECT_EQ(wanted_at({"describe"}), Wanted::kDevice);
  EXPECT_EQ(wanted_at({"send"}), Wanted::kComponent);
  EXPECT_EQ(wanted_at({"inbox", "approve"}), Wanted::kWaiting);
  EXPECT_EQ(wanted_at({"islands"}), Wanted::kNothing);
}

TEST(CliCompletion, ReadsNoMoreThanMayFollow) {
  const auto asked = [](const char* typed) {
    std::vector<std::string> texts;
    for (const auto& question : questions_for(typed, "proxy")) texts.push_back(to_string(question));
    return texts;
  };
  EXPECT_THAT(asked("pro"), ElementsAre("proxy.networks"));
  EXPECT_THAT(asked("7:"), ElementsAre("7:proxy.networks"));
  EXPECT_THAT(asked("robot"), IsEmpty());
  EXPECT_THAT(asked("proxy.w"), ElementsAre("proxy.*.status", "proxy.*"));
  EXPECT_THAT(asked("proxy.wsn-1."), ElementsAre("proxy.wsn-1.*.status", "proxy.wsn-1.*"));
  EXPECT_THAT(asked("7:proxy.wsn-1.7.s"), ElementsAre("7:proxy.wsn-1.7.**"));
}

TEST(CliCompletion, GoesOnPartByPart) {
  EXPECT_EQ(next_step("proxy.wsn-1.7.status", "proxy.w"), "proxy.wsn-1.");
  EXPECT_EQ(next_step("proxy.wsn-1.7.status", "proxy.wsn-1.7."), "proxy.wsn-1.7.status");
  EXPECT_EQ(next_step("proxy.wsn-1.7.status", "proxy.x"), "");
}

}  // namespace
}  // namespace rubicon::cli
