#include "support/rights.h"
#include "tuples/host/host_programs.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::host {
namespace {

using support::Right;
using support::rule;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

constexpr uid_t kService = 990, kAnn = 1000, kBob = 1001, kNobody = 65534;

/// An island of the service with rules, and programs of people.
struct UsersOfAHost : HostEcologyInMemory {
  UsersOfAHost() {
    host.name(kAnn, "ann");
    host.name(kBob, "bob");
    options.judge = std::make_shared<rights::RightsJudge>(
        rights::Rights({rule("user:ann", {Right::kRead, Right::kSet}, {"lamp"}),
                        rule("user:1001", {Right::kRead}, {"**"}), rule("everybody", {Right::kRead}, {"clock"}),
                        rule("group:4", {Right::kSet}, {"clock"})}),
        audit, "proxy", std::vector<std::string>{"user:0", "user:" + std::to_string(kService)});
    island = begin(options, kService);
    home = &island->start(kIsland);
    for (const auto* key : {"lamp", "clock", "secret"}) EXPECT_TRUE(home->set(key, "1"));
    open = home->add_policy(pattern("**"), [](const RemoteSet&) { return SetDecision::applied(); });
    time.run_ready();
  }
  /// What a program of that user reads, and what becomes of its set of `key`.
  std::vector<std::string> keys_for(uid_t user) {
    auto tool = begin({}, user, false);
    auto& space = tool->start(kTool);
    const auto all = read_all(space);
    time.run_for(1ms);
    std::vector<std::string> keys;
    space.list({kIsland, "**"}, [&](const TupleView& tuple) { keys.emplace_back(tuple.key); });
    return keys;
  }
  std::string set_by(uid_t user, const std::string& key) {
    auto tool = begin({}, user, false);
    auto& space = tool->start(kTool);
    std::string answer = "none";
    time.run_ready();
    space.set_remote(kIsland, key, "2", 5s,
                     [&](const Reply& reply) { answer = reply.verdict == Verdict::kApplied ? "applied" : reply.text; });
    time.run_for(1ms);
    return answer;
  }

  std::shared_ptr<support::CollectingAudit> audit = std::make_shared<support::CollectingAudit>();
  HostOptions options;
  std::unique_ptr<Program> island;
  TupleSpace* home = nullptr;
  Handle open;  ///< all may set, as far as the island itself is concerned
};

TEST_F(UsersOfAHost, GetWhatTheRulesGiveTheirNamesAndNumbers) {
  EXPECT_THAT(keys_for(kAnn), UnorderedElementsAre("lamp", "clock"));
  EXPECT_THAT(keys_for(kBob), UnorderedElementsAre("lamp", "clock", "secret"));
  EXPECT_THAT(keys_for(1002), UnorderedElementsAre("clock")) << "of everybody";
  EXPECT_EQ(set_by(kAnn, "lamp"), "applied");
  EXPECT_EQ(set_by(kAnn, "secret"), "user:ann may not set secret: no rule allows it");
  EXPECT_EQ(set_by(kBob, "lamp"), "user:bob may not set lamp: no rule allows it");
  EXPECT_EQ(set_by(1002, "lamp"), "user:1002 may not set lamp: no rule allows it");
  EXPECT_EQ(home->get(kIsland, "lamp")->value, "2");
}

TEST_F(UsersOfAHost, RootAndTheUserOfTheIslandDoWhatTheyLikeAndTheAuditNamesThem) {
  EXPECT_THAT(keys_for(0), UnorderedElementsAre("lamp", "clock", "secret"));
  EXPECT_EQ(set_by(0, "secret"), "applied");
  EXPECT_EQ(set_by(kService, "secret"), "applied");
  EXPECT_EQ(set_by(kBob, "secret"), "user:bob may not set secret: no rule allows it");
  EXPECT_THAT(audit->lines, ElementsAre("user:0 set secret: accepted", "user:990 set secret: accepted",
                                        "user:bob set secret: refused"));
}

/// Of another user namespace: the same number is many people.
TEST_F(UsersOfAHost, AUserWithoutANumberHereIsOneOfEverybodyOnly) {
  EXPECT_THAT(keys_for(kNobody), UnorderedElementsAre("clock"));
  EXPECT_EQ(set_by(kNobody, "clock"), "user:unmapped may not set clock: no rule allows it");
}

TEST_F(UsersOfAHost, AProgramSetsAtOnceAfterItCame) {
  auto tool = begin({}, kAnn, false);
  auto& space = tool->start(kTool);
  bool asked = false;
  std::string answer;
  const auto watch = space.watch_peers([&](OwnerId, PeerEvent) {
    if (!std::exchange(asked, true))
      space.set_remote(kIsland, "lamp", "3", 5s, [&](const Reply& reply) { answer = to_string(reply.verdict); });
  });
  time.run_ready();
  EXPECT_EQ(answer, "applied") << "what comes before the name of its user is known waits for it";
}

TEST_F(UsersOfAHost, NobodyIsAnIslandOutsideTheFolderOfTheService) {
  auto thief = begin({}, kBob, false);
  thief->start(OwnerId(7));
  time.run_for(10ms);
  EXPECT_THAT(home->peers(), testing::IsEmpty());
  EXPECT_THAT(island->log.lines,
              ElementsAre(HasSubstr("it says that it is island 7, but here islands run only as the service")));
}

/// What an island says of roaming devices, and what it relays, counts by its id: nobody has that id meanwhile.
TEST_F(UsersOfAHost, NobodyIsAnIslandWhileItStartsAgain) {
  constexpr OwnerId kHall{2};
  const auto* claim = "ROAMING.lab.7";
  std::vector<std::string> claims;
  const auto followed = home->subscribe(pattern("ROAMING.lab.*"), {}, [&](const Event& event) {
    if (event.kind == EventKind::kSet) claims.push_back(std::string(event.tuple.value));
  });
  auto hall = begin({}, kService);
  ASSERT_TRUE(hall->start(kHall).set(claim, "of the hall"));
  time.run_for(1ms);
  hall.reset();
  auto thief = begin({}, kBob, false);
  ASSERT_TRUE(thief->start(kHall).set(claim, "of a thief"));
  time.run_for(5s);
  EXPECT_THAT(home->peers(), testing::IsEmpty());
  hall = begin({}, kService);
  ASSERT_TRUE(hall->start(kHall).set(claim, "of the hall again"));
  time.run_for(5s);
  EXPECT_THAT(claims, ElementsAre("of the hall", "of the hall again"));
  EXPECT_THAT(home->peers(), ElementsAre(kHall));
  EXPECT_TRUE(SpaceRights::member_of(*home, kHall)->may_use(kHall));
}

/// Hears nothing, and says what it likes of its start.
struct Liar final : LinkListener {
  void on_changes(OwnerId, std::span<const Change>) override {}
  void on_subscribe(OwnerId, const SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const RemoteSet&) override {}
  bool on_reply(OwnerId, const Reply&) override { return true; }
  void on_peer(const PeerIdentity&, PeerEvent) override {}
  void on_summary(OwnerId, std::string_view) override {}
};

/// The island has a console with a free id; a reader has its copies.
TEST_F(UsersOfAHost, NobodyTakesAnIdFromAnotherByAnEarlierStart) {
  auto& console = island->start(kTool);
  ASSERT_TRUE(console.set("clock", "true"));
  std::vector<OwnerId> displaced;
  island->ecology->watch_displaced([&](OwnerId id) { displaced.push_back(id); });
  auto reader = begin({}, kBob, false);
  auto& space = reader->start(kOther);
  const auto all = read_all(space);
  time.run_for(1ms);
  ASSERT_EQ(value(space, kTool, "clock"), "true");
  reader->take();
  auto thief = begin({}, kAnn, false);
  const auto link = std::move(*thief->ecology->join(kTool));
  Liar liar;
  link->attach(liar, 946'684'800'000'001);
  time.run_for(10s);
  EXPECT_THAT(displaced, testing::IsEmpty());
  EXPECT_THAT(reader->take(), testing::IsEmpty()) << "it saw nobody go or come";
  EXPECT_TRUE(console.set("clock", "still true"));
  time.run_for(1ms);
  EXPECT_EQ(value(space, kTool, "clock"), "still true");
  link->detach();
}

TEST_F(UsersOfAHost, AnIslandOfTheServiceIsKnownAsThatIsland) {
  auto other = begin({}, kService);
  other->start(OwnerId(2));
  time.run_for(10ms);
  const auto* who = SpaceRights::member_of(*home, OwnerId(2));
  ASSERT_NE(who, nullptr);
  EXPECT_EQ(who->name, "user:990");
  EXPECT_TRUE(who->may_use(OwnerId(2)));
  EXPECT_FALSE(who->may_use(OwnerId(3)));
}

}  // namespace
}  // namespace rubicon::tuples::host
