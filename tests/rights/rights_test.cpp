#include "rights/rights.h"

#include <gmock/gmock.h>

#include "base/text.h"
#include "rights/rights_case.h"
#include "rights/rights_judge.h"
#include "support/rights.h"

namespace rubicon::rights {
namespace {

using namespace std::chrono_literals;
using tuples::Access;
using tuples::Member;

const Member kRobot{.name = "robot", .roles = {"machine"}};

TEST(Rights, AnswerAsTheTableOfCasesSays) {
  const RightsJudge judge(Rights(rules_in(case_text("home.yaml"))));
  const auto all = members();
  const auto rows = table();
  ASSERT_EQ(judge.rights().rules().size(), 12U);
  ASSERT_GT(rows.size(), 40U);
  for (const auto& row : rows) {
    const auto decision = judge.explain(all.at(row.member), right_of(row.right).value(), row.key);
    const auto asked = row.member + " " + row.right + " " + row.key;
    EXPECT_EQ(decision.allowed ? "yes" : "no", row.answer) << asked;
    EXPECT_EQ(decision.rule ? std::to_string(*decision.rule + 1) : "-", row.rule) << asked;
  }
}

TEST(Rights, DoNotDependOnTheOrderOfTheRules) {
  auto rules = rules_in(case_text("home.yaml"));
  std::reverse(rules.begin(), rules.end());
  const RightsJudge judge(Rights(std::move(rules)));
  const auto all = members();
  for (const auto& row : table()) {
    const auto decision = judge.explain(all.at(row.member), right_of(row.right).value(), row.key);
    EXPECT_EQ(decision.allowed ? "yes" : "no", row.answer) << row.member << " " << row.right << " " << row.key;
  }
}

TEST(Rights, SayWhichRuleDecides) {
  const Rights rights(rules_in(case_text("home.yaml")));
  EXPECT_EQ(rights.decide(kRobot, Right::kRead, "proxy.a").text, "rule 2 (home.yaml:4:5) allows it");
  EXPECT_EQ(rights.decide(kRobot, Right::kSet, "proxy.a.b.actuator.lock-1.command").text,
            "rule 3 (home.yaml:5:5) denies it");
  EXPECT_EQ(rights.decide(kRobot, Right::kSet, "proxy.a").text, "no rule allows it");
}

TEST(Rights, WithoutRulesMembersWithTheRoleAdminMayAll) {
  const Rights rights;
  const Member admin{.name = "anna", .roles = {"admin"}};
  const Member namesake{.name = "admin"};
  for (const auto right : kRights) {
    EXPECT_TRUE(rights.decide(admin, right, "proxy.a.b").allowed);
    EXPECT_FALSE(rights.decide(namesake, right, "proxy.a.b").allowed);
    for (const auto* wire : {"peis", "lan"})
      EXPECT_FALSE(rights.decide({.name = wire, .roles = {"admin"}}, right, "proxy.a.b").allowed);
  }
  EXPECT_TRUE(rights.sees_all(admin));
  EXPECT_FALSE(rights.sees_all(kRobot));
}

TEST(Rights, AnEmptyListOfRulesAllowsNothing) {
  const Rights rights(std::vector<Rule>{});
  EXPECT_FALSE(rights.decide({.name = "anna", .roles = {"admin"}}, Right::kRead, "a").allowed);
}

TEST(Rights, OfSeveralRulesTheFastestDemandCounts) {
  const Rights rights(
      rules_in("rights:\n"
               "  - {who: robot, may: [read, demand], keys: [\"a.**\"], interval: 30s}\n"
               "  - {who: machine, may: demand, keys: [\"a.b.*\"], interval: 5s}\n"
               "  - {who: everybody, may: demand, keys: [\"a.b.free\"]}\n"));
  EXPECT_EQ(rights.access(kRobot, "a.c"), (Access{true, true, 30s}));
  EXPECT_EQ(rights.access(kRobot, "a.b.c"), (Access{true, true, 5s}));
  EXPECT_EQ(rights.access(kRobot, "a.b.free"), (Access{true, true, 0s}));
  EXPECT_EQ(rights.access(kRobot, "b"), (Access{false, false, 0s}));
}

TEST(Rights, WhoSeesAllHasNoExceptionAndNoInterval) {
  const auto sees_all = [](const std::string& rules) {
    return Rights(rules_in("rights:\n  - {who: robot, may: [read, demand], keys: [\"**\"]" + rules)).sees_all(kRobot);
  };
  EXPECT_TRUE(sees_all("}\n"));
  EXPECT_FALSE(sees_all(", interval: 1s}\n"));
  EXPECT_FALSE(sees_all(", not: [a]}\n"));
  EXPECT_FALSE(sees_all("}\n  - {who: machine, may: read, keys: [b], not: [b]}\n"));
  EXPECT_FALSE(Rights(rules_in("rights:\n  - {who: robot, may: read, keys: [\"**\"]}\n")).sees_all(kRobot));
}

TEST(Rights, AnExceptionHoldsForTheKeysAndTheRightsOfItsRule) {
  const Rights rights(
      rules_in("rights:\n  - {who: robot, may: [read, set], keys: [\"**\"]}\n"
               "  - {who: robot, may: read, keys: [\"a.**\"], not: [\"*.x\"]}\n"));
  EXPECT_FALSE(rights.decide(kRobot, Right::kRead, "a.x").allowed);
  EXPECT_TRUE(rights.decide(kRobot, Right::kSet, "a.x").allowed);
  EXPECT_TRUE(rights.decide(kRobot, Right::kRead, "b.x").allowed);
}

TEST(Rights, ToSendToANetworkAsAWholeNeedsThatNoneOfItsDevicesIsExcepted) {
  const auto answer = [](const std::string& rules, std::string_view where = "knx") {
    return Rights(rules_in("rights:\n" + rules)).decide(kRobot, Right::kSend, where).allowed;
  };
  const std::string all = "  - {who: robot, may: send, keys: [\"knx.**\"]}\n";
  EXPECT_TRUE(answer(all));
  EXPECT_FALSE(answer("  - {who: robot, may: send, keys: [\"**\"], not: [knx.1_4_6]}\n"));
  EXPECT_FALSE(answer("  - {who: robot, may: send, keys: [\"*\", \"*.*\"], not: [\"k*.1_4_6\"]}\n"));
  EXPECT_FALSE(answer("  - {who: robot, may: all, not: [\"*.1_4_6.**\"]}\n"));
  EXPECT_FALSE(answer(all + "  - {who: machine, may: send, keys: [\"knx.*\"], not: [knx.1_4_6]}\n"))
      << "of another rule";
  EXPECT_TRUE(answer(all + "  - {who: machine, may: set, keys: [\"knx.*\"], not: [knx.1_4_6]}\n")) << "another right";
  EXPECT_TRUE(answer(all + "  - {who: kids, may: send, keys: [\"knx.*\"], not: [knx.1_4_6]}\n")) << "others";
  EXPECT_TRUE(answer(all + "  - {who: robot, may: send, keys: [\"wsn-1.**\"], not: [\"*.7\"]}\n")) << "elsewhere";
  EXPECT_TRUE(answer("  - {who: robot, may: send, keys: [\"**\"], not: [wsn-1.7]}\n"));
  for (const auto* one : {"own", "island:2", "knx.1_4_7"})
    EXPECT_TRUE(answer("  - {who: robot, may: send, keys: [\"**\"], not: [\"*.1_4_6\"]}\n", one)) << one;
}

TEST(Rights, SayWhyANetworkAsAWholeIsDenied) {
  const Rights rights(rules_in(case_text("home.yaml")));
  EXPECT_EQ(rights.decide(kRobot, Right::kSend, "knx-hall").text,
            "rule 10 (home.yaml:12:5) denies it: what goes to knx-hall reaches the devices that it excepts too");
  EXPECT_EQ(rights.decide(kRobot, Right::kSend, "knx-hall.1_4_6").text, "rule 10 (home.yaml:12:5) denies it");
}

TEST(Rights, AMemberWithTheNameOfAnotherAndOtherRolesIsJudgedByItself) {
  const Rights rights(rules_in("rights:\n  - {who: kids, may: read, keys: [a]}\n"));
  Member tablet{.name = "tablet", .roles = {"kids"}};
  EXPECT_TRUE(rights.decide(tablet, Right::kRead, "a").allowed);
  tablet.roles.clear();
  EXPECT_FALSE(rights.decide(tablet, Right::kRead, "a").allowed);
}

TEST(Rights, ManyMembersAreJudgedRightOneAfterTheOther) {
  std::vector<Rule> rules;
  for (int i = 0; i < 200; ++i) {
    const auto number = std::to_string(i);
    RightSet read;
    read.add(Right::kRead);
    rules.push_back({.who = {"m" + number}, .may = read, .keys = {"a." + number}});
  }
  const Rights rights(std::move(rules));
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 200; ++i) {
      const Member who{.name = "m" + std::to_string(i)};
      EXPECT_TRUE(rights.decide(who, Right::kRead, "a." + std::to_string(i)).allowed);
      EXPECT_FALSE(rights.decide(who, Right::kRead, "a." + std::to_string((i + 1) % 200)).allowed);
    }
  }
}

TEST(Rights, CompileTheRulesOfAMemberOnceForManyMembers) {
  const Rights rights(rules_in("rights:\n  - {who: everybody, may: read, keys: [a]}\n"));
  const auto ask = [&](std::size_t from, std::size_t to) {
    for (auto i = from; i < to; ++i) EXPECT_TRUE(rights.access({.name = "m" + std::to_string(i)}, "a").read);
  };
  for (int round = 0; round < 3; ++round) ask(0, Rights::kMaxKept);
  EXPECT_EQ(rights.compiled(), Rights::kMaxKept);
  ask(Rights::kMaxKept, Rights::kMaxKept + 1);  // m0, which was asked for longest ago, goes
  ask(1, Rights::kMaxKept);
  EXPECT_EQ(rights.compiled(), Rights::kMaxKept + 1);
  ask(0, 1);
  EXPECT_EQ(rights.compiled(), Rights::kMaxKept + 2);
}

TEST(Rights, CompileTheRulesOfAUserOnceForAllRunsOfTools) {
  const Rights rights(
      rules_in("rights:\n  - {who: everybody, may: read, keys: [a]}\n  - {who: 'island:7', may: set, keys: [b]}\n"));
  for (std::uint32_t run = 0; run < 100; ++run) {
    const auto id = 70'000 + run;
    EXPECT_TRUE(rights.access({.name = "ann", .ids = {{id, id}}}, "a").read);
  }
  EXPECT_EQ(rights.compiled(), 1U);
  EXPECT_FALSE(rights.decide({.name = "ann", .ids = {{70'000, 70'000}}}, Right::kSet, "b").allowed);
  EXPECT_TRUE(rights.decide({.name = "ann", .ids = {{70'000, 70'000}, {7, 7}}}, Right::kSet, "b").allowed);
  EXPECT_FALSE(rights.decide({.name = "ann", .ids = {{8, 8}, {70'000, 70'000}}}, Right::kSet, "b").allowed);
  EXPECT_EQ(rights.compiled(), 3U);
}

TEST(Rights, LetVouchOnlyWhomARuleNamesForTheNamesThatItNames) {
  using support::rule;
  auto vouch = rule("member:hall", {});
  vouch.names = {"user:*", "member:desk"};
  const Rights rights(
      std::vector<Rule>{vouch, rule("user:ann@hall", {Right::kSet}, {"a"}), rule("everybody", {Right::kRead}, {"a"})});
  const Member hall{.name = "hall"}, lab{.name = "lab"};
  for (const auto* name : {"user:ann", "user:1000", "member:desk", "user:ann@other"})
    EXPECT_TRUE(rights.may_vouch(hall, name)) << name;
  for (const auto* name : {"member:desk2", "token:t", "", "user:*", "user:a b", "everybody", "peis"})
    EXPECT_FALSE(rights.may_vouch(hall, name)) << name;
  EXPECT_FALSE(rights.may_vouch(hall, "user:" + std::string(200, 'a')));
  EXPECT_FALSE(rights.may_vouch(lab, "user:ann"));
  EXPECT_FALSE(rights.decide(hall, Right::kSet, "a").allowed) << "it gives no right to hall itself";
  EXPECT_TRUE(rights.decide({.name = "user:ann@hall"}, Right::kSet, "a").allowed);
  EXPECT_FALSE(rights.decide({.name = "user:ann"}, Right::kSet, "a").allowed) << "of this host";
  EXPECT_FALSE(rights.decide({.name = "user:ann@lab"}, Right::kSet, "a").allowed);
  EXPECT_TRUE(rights.decide({.name = "user:bob@hall"}, Right::kRead, "a").allowed);
  EXPECT_FALSE(rights.decide({.name = "peis@hall"}, Right::kRead, "a").allowed) << "not everybody";
  EXPECT_FALSE(Rights().may_vouch({.name = "hall", .roles = {"admin"}}, "user:ann")) << "without rules nobody";
}

TEST(Rights, JudgeTheIslandsOfAMemberToo) {
  const Rights rights(rules_in("rights:\n  - {who: \"island:7\", may: read, keys: [a]}\n"));
  const Member seven{.name = "home", .ids = {{7, 7}}}, eight{.name = "home", .ids = {{8, 8}}};
  EXPECT_TRUE(rights.access(seven, "a").read);
  EXPECT_FALSE(rights.access(eight, "a").read);
  EXPECT_TRUE(rights.access(seven, "a").read);
}

}  // namespace
}  // namespace rubicon::rights
