#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"
#include "island/rights_checks.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using rights::RightsJudge;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr OwnerId kHouse{6541}, kPanel{70000};
constexpr const char* kLight = "proxy.dummy-1.hall.actuator.switch-1.command";

IslandConfig config_with(const std::string& more, base::ConfigErrors& errors) {
  auto tree = config::parse_yaml(
      "island: {id: 6541, name: home}\n"
      "networks:\n  dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: constant, value: 21}}, "
      "actuators: {switch-1: {value: off}}}}}\n" +
          more,
      "home.yaml");
  EXPECT_TRUE(tree) << tree.error().text;
  return tree ? read_island_config(std::move(*tree), network_types(), errors) : IslandConfig();
}

IslandConfig config_with(const std::string& more) {
  base::ConfigErrors errors;
  auto config = config_with(more, errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  return config;
}

/// An island with rules and a panel that subscribes to all.
struct IslandRights : testing::Test {
  void start(const std::string& rights) {
    auto config = config_with(rights);
    judge = make_judge(config);
    ecology.judge(kHouse, judge);
    ecology.certify(kPanel, {.name = "panel", .ids = {{number(kPanel), number(kPanel)}}});
    base::ConfigErrors errors;
    island = std::move(*Island::make(std::move(config), time, files, log, ecology, errors));
    island->judge_by(judge, log);
    link = std::move(*ecology.join(kPanel));
    panel.emplace(kPanel, time, *link);
    all = panel->subscribe({kHouse, "**"}, {.passive = true}, [](const tuples::Event&) {});
    island->start();
    time.run_for(2s);
  }
  Result<ReloadPlan> reload(const std::string& rights) {
    base::ConfigErrors errors;
    auto plan = island->reload(config_with(rights), errors);
    time.run_for(1s);
    return plan;
  }
  std::vector<std::string> keys(std::string_view pattern) {
    std::vector<std::string> found;
    panel->list({kHouse, std::string(pattern)}, [&](const tuples::TupleView& tuple) { found.emplace_back(tuple.key); });
    return found;
  }
  tuples::Reply set(std::string_view key, std::string_view value) {
    tuples::Reply answer;
    panel->set_remote(kHouse, key, value, 5s, [&](const tuples::Reply& reply) { answer = reply; });
    time.run_for(1s);
    return answer;
  }

  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology{time};
  std::shared_ptr<RightsJudge> judge;
  std::unique_ptr<Island> island;
  std::unique_ptr<tuples::Link> link;
  std::optional<TupleSpace> panel;
  tuples::Handle all;
};

TEST_F(IslandRights, ASetIsRefusedBeforeTheCommandIsLookedAtAndCounted) {
  start(
      "rights:\n  - {who: panel, may: [read, set], keys: [\"proxy.**\"], not: "
      "[\"proxy.*.*.actuator.switch-*.command\"]}\n"
      "  - {who: panel, may: read, keys: [\"proxy.property.**\"]}\n");
  const auto answer = set(kLight, "nonsense");
  EXPECT_EQ(answer.verdict, tuples::Verdict::kRefused);
  EXPECT_EQ(answer.text, std::string("panel may not set ") + kLight + ": rule 1 (home.yaml:5:5) denies it");
  time.run_for(2s);
  const auto refused = panel->get(kHouse, "proxy.property.rights-refused.value");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->value, "1");
}

TEST_F(IslandRights, AReloadTakesTuplesAwayAndGivesNewOnesWithinASecond) {
  start("rights:\n  - {who: panel, may: read, keys: [\"proxy.*.*.sensor.**\"]}\n");
  EXPECT_FALSE(keys("proxy.*.*.sensor.**").empty());
  EXPECT_THAT(keys("proxy.*.*.actuator.**"), IsEmpty());
  const auto plan = reload("rights:\n  - {who: panel, may: [read, set], keys: [\"proxy.*.*.actuator.**\"]}\n");
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines, ElementsAre("rights: 1 rule from now on"));
  EXPECT_THAT(keys("proxy.*.*.sensor.**"), IsEmpty());
  EXPECT_FALSE(keys("proxy.*.*.actuator.**").empty());
  EXPECT_EQ(set(kLight, "on").verdict, tuples::Verdict::kApplied);
  const auto ended = reload("");
  ASSERT_TRUE(ended) << ended.error().text;
  EXPECT_THAT(ended->lines, ElementsAre("rights: only members with the role admin have any from now on"));
  EXPECT_THAT(keys("**"), IsEmpty());
  EXPECT_EQ(set(kLight, "off").verdict, tuples::Verdict::kRefused);
}

TEST_F(IslandRights, TheSameRulesInOtherLinesChangeNothing) {
  start("rights:\n  - {who: panel, may: read, keys: [\"proxy.**\"]}\n");
  const auto plan = reload("# a comment\nrights:\n  - {may: read, who: panel, keys: [\"proxy.**\"]}\n");
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines, IsEmpty());
}

TEST(RightsChecks, RightsBeginWithARestartWhereNobodyIsJudged) {
  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology{time};
  base::ConfigErrors errors;
  const auto island = std::move(*Island::make(config_with(""), time, files, log, ecology, errors));
  const auto plan = island->plan(config_with("rights:\n  - {who: a, may: all}\n"), errors);
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error().text, HasSubstr("rights: this island started without them; restart it to begin"));
}

TEST(RightsChecks, RightsAndTrustOfTheLanAreNotBoth) {
  const auto errors_of = [](const std::string& tuples, const std::string& rights) {
    const auto config = config_with(rights + "tuples: " + tuples + "\n");
    base::ConfigErrors errors;
    check_rights(config, errors);
    return errors.text();
  };
  const std::string rights = "rights:\n  - {who: a, may: all}\n";
  EXPECT_EQ(errors_of("{engine: dds, trust_lan: yes}", rights),
            "home.yaml:6:34: tuples.trust_lan: with rights the rules for lan and peis say what components of other "
            "hosts may do, expected one of them");
  EXPECT_THAT(errors_of("{engine: peis, trust_lan: no}", rights), HasSubstr("tuples.trust_lan"));
  EXPECT_EQ(errors_of("{engine: [dds, peis]}", rights), "");
  EXPECT_EQ(errors_of("{engine: dds, trust_lan: yes}", ""), "");
}

TEST(RightsChecks, WithoutRightsOrARealmNobodyIsJudged) {
  EXPECT_FALSE(make_judge(config_with("tuples: {engine: dds}\n")));
  EXPECT_TRUE(make_judge(config_with("rights: []\n")));
}

TEST(RightsChecks, WarnOfRulesThatMatchNothing) {
  const auto warnings = [](const std::string& rule, const std::string& more = "") {
    return rights_warnings(config_with("rights:\n  - " + rule + "\n" + more),
                           std::vector<std::string>{"robot", "admin"});
  };
  EXPECT_THAT(warnings("{who: [robot, everybody, island:2, admin], may: read, keys: [proxy.**, proxy.dummy-*.a, "
                       "proxy.settings.command, proxy.property.**, \"**\", \"*.*\", kernel.name]}"),
              IsEmpty());
  EXPECT_THAT(warnings("{who: robot, may: send, keys: [dummy-1.7, own, island:2, \"dummy-1.**\", \"**\"]}"), IsEmpty());
  EXPECT_THAT(
      warnings("{who: [robot, desk], may: all}"),
      ElementsAre("home.yaml:5:5: who: no member and no token has the name or role desk; a user of this host is "
                  "user:desk"));
  EXPECT_THAT(warnings("{who: \"role:desk\", may: all}"),
              ElementsAre("home.yaml:5:5: who: no member and no token has the name or role role:desk"));
  EXPECT_THAT(warnings("{who: robot, may: read, keys: [proxy.knx-hall.**]}"),
              ElementsAre("home.yaml:5:5: keys: 'proxy.knx-hall.**' matches nothing: the island has no network "
                          "'knx-hall'"));
  EXPECT_THAT(warnings("{who: robot, may: send, keys: [wsn-1.7]}"), ElementsAre(HasSubstr("no network 'wsn-1'")));
  EXPECT_THAT(warnings("{who: robot, may: read, keys: [proxy.**], not: [proxy.**]}"),
              ElementsAre("home.yaml:5:5: keys: 'proxy.**' stands in `not` too: the rule denies it"));
  for (const std::string wire : {"peis", "lan"}) {
    const auto rule = "{who: " + wire + ", may: read, keys: [proxy.**]}";
    EXPECT_THAT(warnings(rule),
                ElementsAre("home.yaml:5:5: who: " + wire + " matches no component: the island is not on that engine"));
    EXPECT_THAT(warnings(rule, wire == "lan" ? "tuples: {engine: dds}\n" : "tuples: {engine: peis}\n"),
                ElementsAre(HasSubstr("proves nothing: all that reach that network are `" + wire + "`")));
  }
  EXPECT_THAT(rights_warnings(config_with("rights:\n  - {who: desk, may: all}\n"), std::nullopt), IsEmpty());
}

}  // namespace
}  // namespace rubicon::island
