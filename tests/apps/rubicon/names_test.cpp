#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/commands/completion.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"

namespace rubicon::cli {
namespace {

using testing::AllOf;
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

std::vector<std::string> selected(std::string_view text) {
  std::vector<std::string> patterns;
  const auto selections = parse_selections(text, "value");
  if (!selections) return {"wrong"};
  for (const auto& one : *selections) patterns.push_back(to_string(one.pattern));
  return patterns;
}

TEST(CliNames, APatternIsAlsoTriedAsAShortName) {
  EXPECT_THAT(selected("living.lamp-1"), ElementsAre("living.lamp-1", "*.*.living.*.lamp-1.value"));
  EXPECT_THAT(selected("7:1_0_7.*"), ElementsAre("7:1_0_7.*", "7:*.*.1_0_7.*.*.value"));
  EXPECT_THAT(selected("*.temperature-1"), ElementsAre("*.temperature-1", "*.*.*.*.temperature-1.value"));
  EXPECT_THAT(selected("proxy.**"), ElementsAre("proxy.**"));
  EXPECT_THAT(selected("proxy.**.x"), ElementsAre("wrong"));
  EXPECT_THAT(selected("a b"), ElementsAre("wrong"));
}

TEST(CliNames, AStarWithinAPartSelectsOfWhatThePatternFits) {
  const auto contacts = parse_selections("proxy.*.*.sensor.contact-*.value", "value").value();
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(to_string(contacts[0].pattern), "proxy.*.*.sensor.*.value");
  EXPECT_TRUE(contacts[0].narrower());
  EXPECT_TRUE(contacts[0].fits(OwnerId(7), "proxy.n.d.sensor.contact-door.value"));
  EXPECT_FALSE(contacts[0].fits(OwnerId(7), "proxy.n.d.sensor.light-1.value"));
  EXPECT_FALSE(contacts[0].fits(OwnerId(7), "proxy.n.d.sensor.contact-door.status"));
  const auto short_form = parse_selections("7:liv*.l?mp-*", "command").value();
  ASSERT_EQ(short_form.size(), 2U);
  EXPECT_TRUE(short_form[1].fits(OwnerId(7), "proxy.n.living.actuator.lamp-1.command"));
  EXPECT_FALSE(short_form[1].fits(OwnerId(8), "proxy.n.living.actuator.lamp-1.command"));
  EXPECT_FALSE(short_form[1].fits(OwnerId(7), "proxy.n.living.actuator.lmp-1.command"));
  const auto rest = parse_selections("proxy.dummy-*.**", "value").value();
  EXPECT_TRUE(rest[0].fits(OwnerId(7), "proxy.dummy-1.d.status"));
  EXPECT_FALSE(rest[0].fits(OwnerId(7), "proxy.knx.d.status"));
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

TEST(CliNames, CountsTheDevicesThatAPatternWakes) {
  const auto all = some_devices();
  const auto woken = [&](const char* text) { return count_woken(all, parse_selections(text, "value").value()); };
  EXPECT_EQ(woken("proxy.**"), 3U);
  EXPECT_EQ(woken("2:proxy.*.*.sensor.*.value"), 2U);
  EXPECT_EQ(woken("proxy.wsn.7.sensor.light-1.value"), 2U);
  EXPECT_EQ(woken("proxy.*.*.status"), 0U);
  EXPECT_EQ(woken("proxy.*.*.actuator.*.value"), 0U);
  EXPECT_EQ(woken("proxy.w*.*.sensor.*.value"), 2U);
  EXPECT_EQ(woken("proxy.*.*.sensor.contact-*.value"), 0U);
}

TEST(CliNames, AWordThatNamesNothingGetsTheNearest) {
  const std::vector<std::string> points{"proxy.wsn.7.sensor.light-1", "proxy.knx.hall.sensor.light-1",
                                        "proxy.knx.hall.actuator.lamp-1"};
  EXPECT_EQ(suggest_point(points, "hall.lamp"), "did you mean 'hall.lamp-1'?");
  EXPECT_EQ(suggest_point(points, "knx.hal.lamp-1"), "did you mean 'knx.hall.lamp-1'?");
  EXPECT_EQ(suggest_point(points, "Lamp"), "did you mean 'hall.lamp-1'?");
  EXPECT_EQ(suggest_point(points, "proxy.knx.hall.actuator.lmap-1"), "did you mean 'proxy.knx.hall.actuator.lamp-1'?");
  EXPECT_EQ(suggest_point(points, "frob.nicate"), "");
  EXPECT_EQ(suggest_point({"proxy.knx.hall.actuator.lamp-1", "proxy.knx.hall.actuator.lamp-2"}, "hall.lamp-1"),
            "did you mean 'hall.lamp-2'?")
      << "never what was typed";
  const auto all = some_devices();
  EXPECT_EQ(suggest_device({all, {}}, "Kitchn mote"), "did you mean 'Kitchen mote'?");
  EXPECT_EQ(suggest_device({all, {}}, "2:hal"), "did you mean 'hall' or 'Hall mote'?");
  EXPECT_EQ(suggest_type(all, "temprature"), "did you mean 'temperature'?");
  EXPECT_TRUE(suggest_type(all, "Temperature").starts_with("did you mean 'temperature'"));
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
  Cli cli;
  const auto wanted = [&](const std::vector<std::string>& before) { return wanted_at(cli.app(), before).wanted; };
  EXPECT_EQ(wanted({"get"}), Wanted::kTuple);
  EXPECT_EQ(wanted({"get", "living.lamp-1"}), Wanted::kTuple);
  EXPECT_EQ(wanted({"describe"}), Wanted::kDevice);
  EXPECT_EQ(wanted({"send"}), Wanted::kComponent);
  EXPECT_EQ(wanted({"send", "7"}), Wanted::kNothing);
  EXPECT_EQ(wanted({"inbox", "approve"}), Wanted::kWaiting);
  EXPECT_EQ(wanted({"islands"}), Wanted::kNothing);
  EXPECT_EQ(wanted({"devices", "--type"}), Wanted::kType);
  EXPECT_EQ(wanted({"receive", "--type"}), Wanted::kNothing) << "of a message";
  EXPECT_EQ(wanted({"get", "--island"}), Wanted::kIsland);
  EXPECT_EQ(wanted({"history"}), Wanted::kTuple);
  EXPECT_THAT(fixed_offers(cli.app(), {"history"}, ""), IsEmpty());
  EXPECT_THAT(fixed_offers(cli.app(), {"history", "home.history"}, ""), Contains("query"));
}

TEST(CliCompletion, ANameOfAMemberIsNoFile) {
  Cli cli;
  const auto wanted = [&](const std::vector<std::string>& before) { return wanted_at(cli.app(), before).wanted; };
  for (const auto* command : {"revoke", "renew", "change", "may"})
    EXPECT_EQ(wanted({"trust", command}), Wanted::kMember) << command;
  EXPECT_EQ(wanted({"trust", "add"}), Wanted::kNoFile);
  EXPECT_EQ(wanted({"trust", "revoke", "desk"}), Wanted::kNoFile);
  for (const auto* command : {"join", "show"}) EXPECT_EQ(wanted({"trust", command}), Wanted::kNothing) << command;
  EXPECT_EQ(wanted({"trust", "may", "desk", "set"}), Wanted::kTuple);
  EXPECT_THAT(fixed_offers(cli.app(), {"trust", "may", "inbox"}, ""),
              ElementsAre("read", "demand", "set", "approve", "send"));
  EXPECT_THAT(fixed_offers(cli.app(), {"trust"}, ""), AllOf(Contains("revoke"), Not(Contains("dds"))));
  EXPECT_THAT(fixed_offers(cli.app(), {"trust", "revoke"}, ""), IsEmpty());
}

TEST(CliCompletion, BehindTheTupleThatIsSetStandsAValue) {
  Cli cli;
  EXPECT_EQ(wanted_at(cli.app(), {"set"}).wanted, Wanted::kSettable);
  const auto value = wanted_at(cli.app(), {"--domain", "3", "set", "--ttl", "5s", "living.lamp-1"});
  EXPECT_EQ(value.wanted, Wanted::kValue);
  EXPECT_EQ(value.tuple, "living.lamp-1");
  EXPECT_EQ(wanted_at(cli.app(), {"set", "living.lamp-1", "--ttl"}).wanted, Wanted::kNothing);
  EXPECT_EQ(wanted_at(cli.app(), {"set", "living.lamp-1", "on"}).wanted, Wanted::kNothing);
}

TEST(CliCompletion, AValueIsAWordOfItsType) {
  EXPECT_THAT(value_words(R"({"data_type":"boolean"})"), ElementsAre("off", "on"));
  EXPECT_THAT(value_words(R"({"data_type":"boolean","words":["open","closed"]})"), ElementsAre("open", "closed"));
  EXPECT_THAT(value_words(R"({"data_type":"real","minimum":0})"), IsEmpty());
  EXPECT_THAT(value_words("no json"), IsEmpty());
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

TEST(CliNames, AFormerTypeIsAlsoLookedForByItsNameOfToday) {
  const auto selections = parse_selections("living.illuminance-1", "value");
  ASSERT_TRUE(selections);
  std::vector<std::string> texts;
  for (const auto& one : *selections) texts.push_back(to_string(one.pattern));
  EXPECT_THAT(texts, testing::UnorderedElementsAre("living.illuminance-1", "living.light-1",
                                                   "*.*.living.*.illuminance-1.value", "*.*.living.*.light-1.value"));
  EXPECT_EQ(parse_selections("proxy.*.*.sensor.pir-1.**", "value")->size(), 2U);
  EXPECT_TRUE(any_fits(*parse_selections("7:living.illum*-1", "value"), OwnerId(7), "living.illuminance-1"));
  EXPECT_TRUE(any_fits(*parse_selections("7:dummy-1.*.pir-*", "value"), OwnerId(7),
                       "proxy.dummy-1.living.sensor.motion-2.value"));
}

}  // namespace
}  // namespace rubicon::cli
