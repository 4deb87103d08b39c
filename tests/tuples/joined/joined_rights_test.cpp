#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/space_rights.h"

namespace rubicon::tuples::joined {
namespace {

using namespace std::chrono_literals;

/// Nobody may anything; counts who asked.
struct StrictJudge final : Judge {
  Access access(const Member&, std::string_view) const override { return {false, false, {}}; }
  bool sees_all(const Member&) const override { return false; }
  Result<void> may_set(const Member& who, const RemoteSet&) const override {
    return fail(ErrorCode::kRefused, who.name + " may not");
  }
  Result<void> may_send(const Member& who, std::string_view) const override {
    return fail(ErrorCode::kRefused, who.name + " may not");
  }
  void record(const Member&, const Wish&, const Result<void>&) override {}
  void answered(const Member& who, std::string_view, const RemoteSet&, const Reply&) override {
    asked.push_back(who.name);
  }
  std::vector<std::string> asked;
};

/// The components of a process meet in memory (`own`); all of them are on a second engine too (`wire`), where everybody
/// is `peis`, and where others are.
struct JoinedRights : testing::Test {
  static constexpr OwnerId kIsland{1}, kConsole{65536}, kStranger{70000};

  JoinedRights() {
    own.judge(kIsland, judge);
    wire.judge(kIsland, judge);
    for (const auto id : {kConsole, kStranger}) wire.certify(id, {.name = "peis"});
    island_link = *joined.join(kIsland);
    console_link = *joined.join(kConsole);
    stranger_link = *wire.join(kStranger);
    island.emplace(kIsland, time, *island_link);
    console.emplace(kConsole, time, *console_link);
    stranger.emplace(kStranger, time, *stranger_link);
    EXPECT_TRUE(island->set("a", "1"));
    policy = island->add_policy(*Pattern::parse("a"), [](const RemoteSet&) { return SetDecision::applied(); });
    time.run_for(1s);
  }
  Reply set(TupleSpace& space) {
    Reply answer;
    space.set_remote(kIsland, "a", "2", 5s, [&](const Reply& reply) { answer = reply; });
    time.run_for(1s);
    return answer;
  }
  std::size_t seen_by(TupleSpace& space) {
    std::size_t seen = 0;
    const auto handle = space.subscribe({kIsland, "**"}, {}, [&](const Event&) { ++seen; });
    time.run_for(1s);
    return seen;
  }

  VirtualScheduler time;
  base::NullLogSink log;
  MemoryEcology own{time}, wire{time};
  JoinedEcology joined{std::vector<JoinedEcology::Engine>{{"own", own}, {"wire", wire}}, time, log};
  std::shared_ptr<StrictJudge> judge = std::make_shared<StrictJudge>();
  std::unique_ptr<Link> island_link, console_link, stranger_link;
  std::optional<TupleSpace> island, console, stranger;
  Handle policy;
};

TEST_F(JoinedRights, AComponentOfTheProcessMayAllAndStrangersWhatTheJudgeSays) {
  EXPECT_EQ(seen_by(*console), 1U);
  EXPECT_EQ(set(*console).verdict, Verdict::kApplied);
  EXPECT_EQ(seen_by(*stranger), 0U);
  EXPECT_EQ(set(*stranger).text, "peis may not");
  EXPECT_THAT(judge->asked, testing::ElementsAre("peis"));
}

TEST_F(JoinedRights, ThePolicyOfTheSpaceIsThatOfTheEngineWhereAComponentLives) {
  EXPECT_EQ(SpaceRights::judge(*island), judge.get());
  EXPECT_EQ(SpaceRights::member_of(*island, kStranger)->name, "peis");
  EXPECT_EQ(SpaceRights::member_of(*island, kConsole), nullptr);
  EXPECT_TRUE(SpaceRights::policy(*island).may_send(kConsole, "own"));
  EXPECT_FALSE(SpaceRights::policy(*island).may_send(kStranger, "own"));
  EXPECT_FALSE(SpaceRights::policy(*island).may_send(OwnerId(4711), "own")) << "nobody is there";
}

TEST_F(JoinedRights, WhoeverTakesTheIdOfAComponentOnTheWireIsAStranger) {
  console.reset();
  console_link.reset();
  time.run_for(1s);
  const auto link = std::move(*wire.join(kConsole));
  TupleSpace pretender(kConsole, time, *link);
  time.run_for(1s);
  EXPECT_EQ(seen_by(pretender), 0U);
  EXPECT_EQ(set(pretender).text, "peis may not");
}

}  // namespace
}  // namespace rubicon::tuples::joined
