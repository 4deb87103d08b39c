#include "rights/rights_judge.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "rights/rights_case.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peer_policy.h"

namespace rubicon::rights {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using tuples::Member;

/// Writes down `robot@host verb key=value yes` or `... no: why`.
struct NotedAudit final : Audit {
  void write(const AuditLine& line) override {
    quotes.push_back(line.quotes);
    lines.push_back(line.who.name + "@" + std::string(line.host) + " " + std::string(line.verb) + " " +
                    std::string(line.key) + "=" + std::string(line.value) +
                    (line.accepted ? " yes" : " no: " + std::string(line.why)));
  }
  std::vector<std::string> lines;
  std::vector<bool> quotes;
};

tuples::RemoteSet set_of(std::string_view key) {
  tuples::RemoteSet set;
  set.key = key;
  set.value = "on";
  return set;
}

struct JudgeOfHome : testing::Test {
  std::shared_ptr<NotedAudit> audit = std::make_shared<NotedAudit>();
  RightsJudge judge{Rights(rules_in(case_text("home.yaml"))), audit};
  std::map<std::string, Member> all = members();
};

TEST_F(JudgeOfHome, RefusesByNameAndNamesTheRule) {
  EXPECT_EQ(judge.may_set(all["robot"], set_of("proxy.a.b.actuator.lock-1.command")).error().text,
            "robot may not set proxy.a.b.actuator.lock-1.command: rule 3 (home.yaml:5:5) denies it");
  EXPECT_EQ(judge.may_send(all["robot"], "own").error().text, "robot may not send to own: no rule allows it");
  EXPECT_EQ(judge.refused(), 2U);
  EXPECT_FALSE(judge.explain(all["robot"], Right::kSend, "own").allowed);
  EXPECT_EQ(judge.refused(), 2U) << "a question is no refusal";
}

TEST_F(JudgeOfHome, APropertyHasTheSameRightsByItsOtherName) {
  constexpr auto kOther = "proxy.a.b.property.sampling-rate.command";
  judge.replace(Rights(
      rules_in("rights:\n  - {who: robot, may: set, keys: [\"proxy.**\"], not: [\"proxy.*.*.property.rate.*\"]}\n"
               "  - {who: panel, may: set, keys: [\"proxy.*.*.property.sampling-rate.command\"]}\n")));
  EXPECT_FALSE(judge.may_set(all["robot"], set_of(kOther)));
  EXPECT_TRUE(judge.may_set(all["panel"], set_of(kOther)));
  EXPECT_TRUE(judge.may_set(all["panel"], set_of("proxy.a.b.property.rate.command")));
  judge.answered(all["panel"], "desk", set_of(kOther), {});
  EXPECT_THAT(audit->lines, ElementsAre("panel@desk set proxy.a.b.property.rate.command=on yes"));
}

TEST_F(JudgeOfHome, WhatHasSeveralNamesIsDeniedByEachAndAllowedByAny) {
  judge.replace(
      Rights(rules_in("rights:\n  - {who: robot, may: [set, send], keys: [\"a.*\", b.1], not: [a.2, b.3]}\n")));
  const auto may = [&](std::vector<std::string> names) {
    const auto answer = judge.may_by_names(all["robot"], tuples::Act::kSend, names);
    EXPECT_EQ(judge.may_by_names(all["robot"], tuples::Act::kSet, names).has_value(), answer.has_value());
    return answer ? "yes" : answer.error().text;
  };
  EXPECT_EQ(may({"a.1", "c.1"}), "yes");
  EXPECT_EQ(may({"c.1", "a.1"}), "yes");
  EXPECT_EQ(may({"a.1", "a.2"}), "robot may not send to a.2: rule 1 (home.yaml:2:5) denies it");
  EXPECT_EQ(may({"c.1", "c.2"}), "robot may not send to c.1: no rule allows it");
}

TEST_F(JudgeOfHome, KnowsWhoIsBehindASetAsLongAsTheHandleLives) {
  auto handle = judge.speak_for(all["robot"], OwnerId(70000), 7);
  ASSERT_TRUE(judge.spoken_for(OwnerId(70000), 7));
  EXPECT_EQ(judge.spoken_for(OwnerId(70000), 7)->name, "robot");
  EXPECT_FALSE(judge.spoken_for(OwnerId(70000), 8));
  handle.reset();
  EXPECT_FALSE(judge.spoken_for(OwnerId(70000), 7));
}

TEST_F(JudgeOfHome, TheInboxNeedsTheRightToApproveAndNoOther) {
  judge.replace(
      Rights(rules_in("rights:\n  - {who: robot, may: set, keys: [\"proxy.**\"]}\n"
                      "  - {who: panel, may: approve, keys: [\"proxy.**\"]}\n")));
  for (const auto* key : {"proxy.inbox", "proxy.inbox.wsn-1.9"}) {
    EXPECT_FALSE(judge.may_set(all["robot"], set_of(key))) << key;
    EXPECT_TRUE(judge.may_set(all["panel"], set_of(key))) << key;
  }
  EXPECT_TRUE(judge.may_set(all["robot"], set_of("proxy.inboxes")));
  EXPECT_FALSE(judge.may_set(all["panel"], set_of("proxy.inboxes")));
  EXPECT_TRUE(judge.explain(all["panel"], Right::kSet, "proxy.inbox").allowed);
}

TEST(RightsJudge, TheInboxIsBelowThePrefixOfTheIsland) {
  RightsJudge judge{Rights(rules_in("rights:\n  - {who: robot, may: set, keys: [\"**\"]}\n")), nullptr, "home"};
  EXPECT_FALSE(judge.may_set({.name = "robot"}, set_of("home.inbox.a")));
  EXPECT_TRUE(judge.may_set({.name = "robot"}, set_of("proxy.inbox.a")));
}

TEST_F(JudgeOfHome, AQuestionAndASetHaveTheSameAnswer) {
  for (const auto& row : table()) {
    if (row.right == "set") {
      EXPECT_EQ(judge.may_set(all[row.member], set_of(row.key)).has_value(), row.answer == "yes") << row.key;
    }
  }
}

TEST_F(JudgeOfHome, WritesALineOfEachAnswer) {
  auto append = set_of("proxy.a.b.x");
  append.append = true;
  judge.answered(all["robot"], "host-1", set_of("proxy.a.b.x"), {});
  judge.answered(all["robot"], "host-1", append, {.verdict = tuples::Verdict::kRefused, .text = "it is read-only"});
  judge.answered(all["panel"], "", set_of("proxy.inbox"), {});
  judge.answered(all["panel"], "", set_of("GATEWAY"), {});
  judge.answered(all["two"], "", set_of("ROAMING.lab.7"), {.verdict = tuples::Verdict::kRefused, .text = "not here"});
  judge.answered(all["panel"], "", set_of("GATEWAY.x"), {.verdict = tuples::Verdict::kRefused, .text = "no such"});
  judge.record(all["two"], {.host = "h", .verb = "send", .key = "own", .value = "v"}, {});
  judge.record(all["two"], {.host = "h", .verb = "send", .key = "own", .value = ""}, fail(ErrorCode::kRefused, "no"));
  EXPECT_THAT(
      audit->lines,
      ElementsAre("robot@host-1 set proxy.a.b.x=on yes", "robot@host-1 append proxy.a.b.x=on no: it is read-only",
                  "panel@ approve proxy.inbox=on yes", "two@ set ROAMING.lab.7= no: not here",
                  "panel@ send GATEWAY.x= no: no such", "two@h send own=v yes", "two@h send own= no: no"));
}

TEST_F(JudgeOfHome, OnlyTheOwnerOfATupleQuotesItsValue) {
  judge.replace(Rights(rules_in("rights:\n  - {who: robot, may: set, keys: [proxy.a]}\n")));
  const tuples::Reply by_owner{.verdict = tuples::Verdict::kRefused, .text = "'on' is not a number"};
  const tuples::Reply by_rules{.verdict = tuples::Verdict::kRefused,
                               .text = judge.may_set(all["robot"], set_of("proxy.b")).error().text};
  judge.answered(all["robot"], "", set_of("proxy.a"), by_owner);
  judge.answered(all["robot"], "", set_of("proxy.b"), by_rules);
  judge.answered(all["robot"], "", set_of("proxy.a"), {});
  // What follows its device needs the right to set the claim only.
  judge.answered(all["robot"], "", set_of("proxy.b"), by_owner);
  EXPECT_THAT(audit->quotes, ElementsAre(true, false, false, true));
}

TEST_F(JudgeOfHome, AQuestionCountsAsNoRefusal) {
  const std::vector<std::string> names{"own"};
  const auto asked = judge.would_allow(all["robot"], tuples::Act::kSend, names);
  EXPECT_EQ(judge.refused(), 0U);
  EXPECT_EQ(asked.error().text, judge.may_by_names(all["robot"], tuples::Act::kSend, names).error().text);
  EXPECT_EQ(judge.refused(), 1U);
}

/// The table once more, over the memory engine: an island and one member at a time.
struct RightsOverMemory : testing::Test {
  static constexpr OwnerId kIsland{1}, kComponent{70000};

  RightsOverMemory() {
    ecology.judge(kIsland, judge);
    link = std::move(*ecology.join(kIsland));
    island.emplace(kIsland, time, *link);
    for (const auto& row : table()) {
      if (row.right == "send" || row.key.find(':') != row.key.npos) continue;
      EXPECT_TRUE(island->declare(row.key, "1"));
    }
    policy = island->add_policy(*Pattern::parse("**"),
                                [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); });
    demands = island->watch_demand(*Pattern::parse("**"), [this](const tuples::Demand& demand) {
      wanted[std::string(demand.key)] = demand.wanted;
    });
  }

  static Member at_component(const std::string& name) {
    auto member = members().at(name);
    if (name != tuples::kPeisMember) member.ids.push_back({number(kComponent), number(kComponent)});
    return member;
  }

  bool ask(const Row& row) {
    wanted.clear();
    ecology.certify(kComponent, at_component(row.member));
    auto its_link = std::move(*ecology.join(kComponent));
    tuples::TupleSpace space(kComponent, time, *its_link);
    time.run_for(10ms);
    if (row.right == "send") return tuples::SpaceRights::policy(*island).may_send(kComponent, row.key).has_value();
    if (row.right == "set" || row.right == "approve") {
      std::optional<tuples::Verdict> verdict;
      space.set_remote(kIsland, row.key, "2", 5s, [&](const tuples::Reply& reply) { verdict = reply.verdict; });
      time.run_for(10ms);
      return verdict == tuples::Verdict::kApplied;
    }
    const auto handle = space.subscribe({kIsland, row.key}, {}, [](const tuples::Event&) {});
    time.run_for(10ms);
    return row.right == "read" ? space.get(kIsland, row.key).has_value() : wanted[row.key];
  }

  base::VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::shared_ptr<RightsJudge> judge = std::make_shared<RightsJudge>(Rights(rules_in(case_text("home.yaml"))));
  std::unique_ptr<tuples::Link> link;
  std::optional<tuples::TupleSpace> island;
  tuples::Handle policy, demands;
  std::map<std::string, bool> wanted;
};

TEST_F(RightsOverMemory, AnswerAsTheTableOfCasesSays) {
  const Rights rights(rules_in(case_text("home.yaml")));
  for (const auto& row : table()) {
    // Who may not read a tuple cannot wake it.
    const bool blind = row.right == "demand" && !rights.decide(members().at(row.member), Right::kRead, row.key).allowed;
    EXPECT_EQ(ask(row), row.answer == "yes" && !blind) << row.member << " " << row.right << " " << row.key;
  }
}

TEST_F(RightsOverMemory, ManyKeysAreSeenByWhoMaySeeThem) {
  const auto seen_by = [&](const std::string& member) {
    ecology.certify(kComponent, at_component(member));
    auto its_link = std::move(*ecology.join(kComponent));
    tuples::TupleSpace space(kComponent, time, *its_link);
    std::size_t seen = 0;
    const auto handle = space.subscribe({kIsland, "**"}, {}, [&](const tuples::Event&) { ++seen; });
    time.run_for(10ms);
    return seen;
  };
  EXPECT_EQ(seen_by("peis"), 2U);
  EXPECT_GT(seen_by("robot"), seen_by("peis"));
  EXPECT_GT(seen_by("anna"), seen_by("robot"));
}

}  // namespace
}  // namespace rubicon::rights
