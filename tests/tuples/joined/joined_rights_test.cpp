#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peer_policy.h"

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
  Result<void> may_by_names(const Member&, Act, std::span<const std::string>) const override {
    return fail(ErrorCode::kRefused, "no");
  }
  Handle speak_for(const Member&, OwnerId, std::uint64_t) override { return {}; }
  const Member* spoken_for(OwnerId, std::uint64_t) const override { return nullptr; }
  void record(const Member&, const OtherRequest&, const Result<void>&) override {}
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

/// Whatever a stranger likes to say of itself.
struct Liar final : LinkListener {
  void on_changes(OwnerId, std::span<const Change>) override {}
  void on_subscribe(OwnerId, const SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const RemoteSet&) override {}
  bool on_reply(OwnerId, const Reply& reply) override {
    answers.push_back(reply.text);
    return true;
  }
  void on_peer(const PeerIdentity& peer, PeerEvent) override { starts[peer.id] = peer.incarnation; }
  void on_summary(OwnerId, std::string_view) override {}

  std::vector<std::string> answers;
  std::map<OwnerId, std::uint64_t> starts;
};

/// A component that `own` knows is met by the island, and a stranger takes its id on `wire`.
struct WithAStranger : JoinedRights {
  static constexpr OwnerId kOwner{2}, kWitness{65999};
  static constexpr WallTime kYear2100{std::chrono::seconds(4'102'444'800)};

  WithAStranger() {
    wire.certify(kOwner, {.name = "peis"});
    witness_link->attach(witness, 1);
  }
  void start_owner() {
    owner_link = *own.join(kOwner);
    owner.emplace(kOwner, time, *owner_link);
    EXPECT_TRUE(owner->set("lamp", "on"));
    time.run_for(1s);
  }
  void start_liar(std::uint64_t start) {
    liar_link = *wire.join(kOwner);
    liar_link->attach(liar, start);
    time.run_for(1s);
  }
  void forge(std::string_view value) {
    TupleSet made;
    made.tuple.key = "lamp";
    made.tuple.value = value;
    made.tuple.sequence = 99;
    made.tuple.media_type = "text/plain";
    liar_link->publish(kIsland, std::vector<Change>{Restart{kYear2100}, made});
    time.run_for(1s);
  }
  std::vector<std::string> liar_sets() {
    RemoteSet set;
    set.from = kOwner;
    set.owner = kIsland;
    set.key = "a";
    set.value = "3";
    set.request = 1;
    EXPECT_TRUE(liar_link->remote_set(set));
    time.run_for(1s);
    return std::exchange(liar.answers, {});
  }
  std::string lamp() const {
    const auto tuple = island->get(kOwner, "lamp");
    return tuple ? std::string(tuple->value) : "absent";
  }
  std::string member() {
    const auto* who = SpaceRights::member_of(*island, kOwner);
    return who ? who->name : "none";
  }

  const Member two{.name = "two", .ids = {{2, 2}}};
  Liar witness, liar;
  std::unique_ptr<Link> witness_link = *own.join(kWitness), owner_link, liar_link;
  std::optional<TupleSpace> owner;
  Handle follow = island->subscribe({kOwner, "**"}, {}, [](const Event&) {});
};

TEST_F(WithAStranger, AComponentOfTheProcessYieldsToNoLaterStart) {
  start_owner();
  start_liar(witness.starts.at(kOwner) + 1'000'000);
  EXPECT_EQ(member(), "none") << "it is of this process";
  EXPECT_EQ(set(*owner).verdict, Verdict::kApplied);
  EXPECT_EQ(seen_by(*owner), 1U);
  forge("forged");
  EXPECT_EQ(lamp(), "on");
  EXPECT_THAT(liar_sets(), testing::ElementsAre("setting 'a': another component with id 2 is present"));
  EXPECT_THAT(judge->asked, testing::ElementsAre("peis")) << "each set has a line in the audit";
}

TEST_F(WithAStranger, AMemberYieldsToNoLaterStart) {
  own.certify(kOwner, two);
  start_owner();
  start_liar(witness.starts.at(kOwner) + 1'000'000);
  EXPECT_EQ(member(), "two");
  EXPECT_EQ(set(*owner).text, "two may not");
}

TEST_F(WithAStranger, NobodyForgesValuesOfAMemberWhoseStartHeCopies) {
  own.certify(kOwner, two);
  start_owner();
  start_liar(witness.starts.at(kOwner));
  forge("forged");
  EXPECT_EQ(lamp(), "on");
  ASSERT_TRUE(owner->set("lamp", "off"));
  time.run_for(1s);
  EXPECT_EQ(lamp(), "off") << "its own stream counts still";
  EXPECT_THAT(liar_sets(),
              testing::ElementsAre("setting 'a': wire does not prove that it is component 2, which own proves"));
}

TEST_F(WithAStranger, NobodyAnswersForAMember) {
  own.certify(kOwner, two);
  start_owner();
  start_liar(witness.starts.at(kOwner));
  Reply answer;
  const auto request = island->set_remote(kOwner, "lamp", "x", 5s, [&answer](const Reply& reply) { answer = reply; });
  liar_link->reply({kIsland, request, Verdict::kApplied, {}, {}});
  time.run_for(1s);
  EXPECT_EQ(answer.text, "lamp is read-only for other components");
}

TEST_F(WithAStranger, AMemberThatIsBackTakesItsIdAndItsTuples) {
  own.certify(kOwner, two);
  start_owner();
  own.cut(kIsland, kOwner);
  start_liar(witness.starts.at(kOwner));
  forge("forged");
  EXPECT_EQ(member(), "peis");
  own.mend(kIsland, kOwner);
  time.run_for(1s);
  EXPECT_EQ(member(), "two");
  EXPECT_EQ(lamp(), "on");
  ASSERT_TRUE(owner->set("lamp", "off"));
  time.run_for(1s);
  EXPECT_EQ(lamp(), "off");
}

TEST_F(WithAStranger, AMemberGoesOnByTheOtherEngineAsAStranger) {
  own.certify(kOwner, two);
  owner_link = *joined.join(kOwner);
  owner.emplace(kOwner, time, *owner_link);
  ASSERT_TRUE(owner->set("lamp", "on"));
  time.run_for(1s);
  EXPECT_EQ(member(), "two");
  own.cut(kIsland, kOwner);
  ASSERT_TRUE(owner->set("lamp", "off"));
  time.run_for(1s);
  EXPECT_EQ(member(), "peis");
  EXPECT_EQ(lamp(), "off");
  own.mend(kIsland, kOwner);
  ASSERT_TRUE(owner->set("lamp", "dim"));
  time.run_for(1s);
  EXPECT_EQ(member(), "two");
  EXPECT_EQ(lamp(), "dim");
}

}  // namespace
}  // namespace rubicon::tuples::joined
