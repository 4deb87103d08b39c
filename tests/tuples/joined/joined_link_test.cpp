#include "tuples/joined/joined_link.h"

#include "tuples/joined/two_engines.h"

namespace rubicon::tuples::joined {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr OwnerId kFar{70000};
constexpr std::uint64_t kStart = 1'800'000'000'000'000;

/// Writes down what it is asked, and refuses where its test says so.
struct EnginePolicy final : OpenPolicy {
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return answer(); }
  Result<void> may_set(const RemoteSet&) override { return answer(); }
  Result<void> answer() const {
    if (open) return {};
    return fail(ErrorCode::kRefused, "this engine is closed");
  }
  bool open = true;
};

/// An engine whose other components are played by the test.
struct PlayedEngine {
  struct PlayedLink final : Link {
    explicit PlayedLink(PlayedEngine& one) : engine(one) {}
    void attach(LinkListener& listener, std::uint64_t) override { engine.far = &listener; }
    void detach() override { engine.far = nullptr; }
    bool publish(OwnerId, std::span<const Change> changes) override {
      if (engine.full) return false;
      engine.published += changes.size();
      return true;
    }
    void subscribe(const SubscriptionSpec&) override {}
    void unsubscribe(std::uint32_t) override {}
    Result<void> remote_set(const RemoteSet& set) override {
      if (!engine.takes_sets) return fail(ErrorCode::kBusy, "the window is full");
      engine.sets.push_back(set.value);
      engine.time_to_live = set.time_to_live;
      return {};
    }
    void reply(const Reply& reply) override { engine.replies.push_back(std::string(to_string(reply.verdict))); }
    void describe(std::string) override {}
    std::vector<OwnerId> peers() const override { return {}; }
    PeerPolicy& policy() override { return engine.policy; }
    PlayedEngine& engine;
  };

  void set(std::string_view key, std::string_view value, std::uint64_t sequence) {
    TupleSet made;
    made.tuple.key = key;
    made.tuple.value = value;
    made.tuple.sequence = sequence;
    made.tuple.media_type = "text/plain";
    receive({made});
  }
  void receive(const std::vector<Change>& changes) { far->on_changes(kFar, changes); }
  void command() {
    RemoteSet set;
    set.from = kFar;
    set.owner = OwnerId(1);
    set.request = ++requests;
    set.key = "own";
    set.value = "1";
    far->on_remote_set(set);
  }

  LinkListener* far = nullptr;
  EnginePolicy policy;
  bool full = false, takes_sets = false;
  Duration time_to_live{0};
  Seen sets;  ///< values of the remote sets that it was given
  std::size_t published = 0;
  std::uint64_t requests = 0;
  Seen replies;
};

struct PlayedEngines : testing::Test {
  std::vector<JoinedLink::Engine> engines() {
    std::vector<JoinedLink::Engine> made;
    made.push_back({"dds", std::make_unique<PlayedEngine::PlayedLink>(dds)});
    made.push_back({"peis", std::make_unique<PlayedEngine::PlayedLink>(peis)});
    return made;
  }
  static Restart restart(int number) {
    return {WallTime(std::chrono::microseconds(kStart) + std::chrono::microseconds(number))};
  }
  Seen take_events() {
    time.run_ready();
    return std::exchange(events, {});
  }

  VirtualScheduler time;
  support::CollectingLog log;
  PlayedEngine dds, peis;
  JoinedLink link{OwnerId(1), engines(), time, log};
  TupleSpace space{OwnerId(1), time, link};
  Seen events;
  Handle watch = space.watch_peers([this](OwnerId, PeerEvent event) { events.push_back(event_name(event)); });
  Listener seen;
  Handle subscription = space.subscribe(pattern("70000:**"), {}, seen.call());
  const PeerIdentity who{kFar, kStart, "host"};
  const PeerIdentity restarted{kFar, kStart + 1, "host"};
  const PeerIdentity stand_in{kFar, kStart + 2, "host~2"};
  const PeerIdentity kernel{kFar, 4711, "pc"};
};

TEST_F(PlayedEngines, DropWhatIsLateOnTheEngineThatTheOwnerGaveUp) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  dds.receive({restart(1)});
  dds.set("x", "1", 1);
  peis.receive({restart(2)});  // the owner lost this component on dds, which this component did not notice
  peis.set("x", "2", 2);
  dds.receive({TupleGone{EventKind::kDeleted, "x", 1}, SnapshotEnd{1}});
  dds.set("y", "late", 1);
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("x=1", "x=2"));
  TupleSet back;
  back.tuple.key = "x";
  back.tuple.value = "3";
  back.tuple.sequence = 3;
  dds.receive({TupleGone{EventKind::kDeleted, "x", 2}, restart(3), back});
  peis.set("x", "late", 4);
  peis.receive({restart(2)});
  peis.set("x", "later", 5);
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("x=3"));
}

TEST_F(PlayedEngines, FollowTheLatestStreamWhateverOrderTheBeginningsArriveIn) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  dds.receive({restart(3)});
  peis.receive({restart(2)});
  dds.set("x", "right", 1);
  peis.set("x", "wrong", 2);
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("x=right"));
}

TEST_F(PlayedEngines, StayWithTheStreamWhenAnotherEngineHasItsConnectionBack) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  peis.receive({Restart{}});  // before any stream began
  dds.set("x", "1", 1);
  dds.receive({restart(1)});
  dds.set("x", "2", 2);
  peis.receive({Restart{}});
  dds.set("x", "3", 3);
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("x=1", "x=2", "x=3"));
  dds.receive({Restart{}});
  peis.receive({restart(1)});
  peis.set("x", "late", 4);
  time.run_ready();
  EXPECT_THAT(seen.take(), IsEmpty());
}

struct SetsToAStandIn : PlayedEngines {
  void SetUp() override {
    dds.takes_sets = peis.takes_sets = true;
    dds.far->on_peer(stand_in, PeerEvent::kUp);
    set("1");
    set("2");
    time.run_for(1500ms);
    EXPECT_THAT(dds.sets, IsEmpty());
  }
  void set(std::string_view value) {
    space.set_remote(kFar, "x", value, 5s, [this](const Reply& reply) { answers.push_back(reply.text); });
    time.run_ready();
  }
  Seen answers;
};

TEST_F(SetsToAStandIn, GoToTheComponentItselfThatIsMetALittleLater) {
  peis.far->on_peer(who, PeerEvent::kUp);
  set("3");
  EXPECT_THAT(peis.sets, ElementsAre("1", "2", "3"));
  time.run_for(2s);
  EXPECT_THAT(dds.sets, IsEmpty());
  EXPECT_THAT(answers, IsEmpty());
}

TEST_F(SetsToAStandIn, GoToItWhenOnlyTheStandInIsMet) {
  time.run_for(500ms);
  EXPECT_THAT(dds.sets, ElementsAre("1", "2"));
  EXPECT_EQ(dds.time_to_live, 3s);
  set("3");
  EXPECT_THAT(dds.sets, ElementsAre("1", "2", "3"));
}

TEST_F(SetsToAStandIn, FailIfItIsLost) {
  dds.far->on_peer(stand_in, PeerEvent::kLost);
  time.run_for(1s);
  EXPECT_THAT(answers, ElementsAre("component 70000 is lost", "component 70000 is lost"));
}

TEST_F(SetsToAStandIn, AreBounded) {
  for (int i = 0; i < 1000; ++i) set("more");
  EXPECT_THAT(answers,
              ElementsAre("too many remote sets wait for their owners", "too many remote sets wait for their owners"));
  time.run_for(1s);
  EXPECT_EQ(dds.sets.size(), HeldSets::kMax);
}

TEST_F(PlayedEngines, FollowARestartAtOnceAlthoughOneStillSeesTheEarlierStart) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  dds.far->on_peer(who, PeerEvent::kLost);
  dds.far->on_peer(restarted, PeerEvent::kUp);
  EXPECT_THAT(take_events(), ElementsAre("up", "lost", "up", "lost", "up"));
  dds.set("x", "new", 1);
  peis.set("x", "old", 9);
  time.run_for(50s);
  EXPECT_THAT(seen.take(), ElementsAre("x=new"));
  peis.far->on_peer(who, PeerEvent::kLost);
  peis.far->on_peer(restarted, PeerEvent::kUp);
  time.run_for(100s);
  EXPECT_THAT(take_events(), IsEmpty());
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(PlayedEngines, LogTwoStartsOfOneHostThatBothStay) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(restarted, PeerEvent::kUp);
  EXPECT_THAT(take_events(), ElementsAre("up", "lost", "up"));
  time.run_for(59s);
  EXPECT_THAT(log.lines, IsEmpty());
  time.run_for(2s);
  EXPECT_THAT(log.lines, ElementsAre("tuples: two components have id 70000: one on peis on host host and one on dds on "
                                     "host host. The one on dds is ignored: give one of them another id"));
}

TEST_F(PlayedEngines, SayNothingOfAPeerThatIsIdentifiedWhileItIsMet) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(kernel, PeerEvent::kUp);  // before its hello
  time.run_for(1s);
  peis.far->on_peer(kernel, PeerEvent::kLost);
  peis.far->on_peer(who, PeerEvent::kUp);
  time.run_for(100s);
  EXPECT_THAT(take_events(), ElementsAre("up"));
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(PlayedEngines, ForgetAComponentThatLeftWhereItLivesAlthoughTheOtherStillSeesIt) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  dds.far->on_peer(who, PeerEvent::kLeft);
  EXPECT_THAT(take_events(), ElementsAre("up", "left"));
  EXPECT_THAT(space.peers(), IsEmpty());
  peis.far->on_peer(who, PeerEvent::kLost);
  dds.far->on_peer(restarted, PeerEvent::kUp);
  EXPECT_THAT(take_events(), ElementsAre("up"));
  peis.far->on_peer(restarted, PeerEvent::kUp);
  peis.far->on_peer(restarted, PeerEvent::kLeft);
  EXPECT_THAT(take_events(), IsEmpty()) << "forged: it lives on dds, which says nothing";
}

TEST_F(PlayedEngines, KeepThePolicyOfEachInForce) {
  ASSERT_TRUE(space.set("own", "0"));
  const auto applies = space.add_policy(pattern("own"), [](const RemoteSet&) { return SetDecision::applied(); });
  peis.policy.open = false;
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  dds.command();
  peis.command();
  EXPECT_THAT(dds.replies, ElementsAre("applied"));
  EXPECT_THAT(peis.replies, ElementsAre("refused")) << "by the engine that brought it, which carries the reply";
  dds.far->on_subscribe(kFar, {9, pattern("own"), {}});
  peis.far->on_subscribe(kFar, {9, pattern("own"), {}});
  time.run_ready();
  EXPECT_EQ(dds.published, 3U) << "restart, value, end of the snapshot";
  dds.far->on_peer(who, PeerEvent::kLost);
  time.run_ready();
  EXPECT_EQ(peis.published, 1U) << "the restart: its policy refuses the subscription";
  EXPECT_EQ(space.stats().refused, 2U);
}

TEST_F(PlayedEngines, BoundTheSubscriptionsOfOneComponent) {
  dds.far->on_peer(who, PeerEvent::kUp);
  peis.far->on_peer(who, PeerEvent::kUp);
  for (std::uint32_t id = 1; id <= JoinedLink::kMaxSubscriptions + 5; ++id)
    peis.far->on_subscribe(kFar, {id, pattern("nothing"), {}});
  EXPECT_THAT(log.lines, ElementsAre("tuples: component 70000 has too many subscriptions: one is ignored"));
}

TEST_F(PlayedEngines, PassOnThatAnEngineIsFull) {
  ASSERT_TRUE(space.set("own", "0"));
  dds.full = true;
  dds.far->on_peer(who, PeerEvent::kUp);
  dds.far->on_subscribe(kFar, {9, pattern("own"), {}});
  time.run_ready();
  EXPECT_EQ(dds.published, 0U);
  dds.full = false;
  time.run_for(10ms);
  EXPECT_EQ(dds.published, 3U);
  Reply answer;
  space.set_remote(kFar, "x", "1", 1s, [&](const Reply& reply) { answer = reply; });
  time.run_ready();
  EXPECT_EQ(answer.text, "the window is full");
}

/// Detaches the link inside a call.
struct LeavingListener final : LinkListener {
  void on_changes(OwnerId, std::span<const Change>) override { leave(); }
  void on_subscribe(OwnerId, const SubscriptionSpec&) override { leave(); }
  void on_unsubscribe(OwnerId, std::uint32_t) override { leave(); }
  void on_remote_set(const RemoteSet&) override { leave(); }
  bool on_reply(OwnerId, const Reply&) override {
    leave();
    return true;
  }
  void on_peer(const PeerIdentity&, PeerEvent) override { count(); }
  void on_summary(OwnerId, std::string_view) override { leave(); }
  void count() {
    if (++peers == leave_at) leave();
  }
  void leave() {
    ++calls;
    link->detach();
  }
  JoinedLink* link = nullptr;
  int peers = 0, leave_at = 100, calls = 0;
};

TEST_F(PlayedEngines, MayBeDetachedInAnyCall) {
  PlayedEngine one, other;
  std::vector<JoinedLink::Engine> made;
  made.push_back({"one", std::make_unique<PlayedEngine::PlayedLink>(one)});
  made.push_back({"other", std::make_unique<PlayedEngine::PlayedLink>(other)});
  JoinedLink joined(OwnerId(2), std::move(made), time, log);
  RemoteSet command;
  command.from = kFar;
  LeavingListener listener;
  listener.link = &joined;
  const auto meet = [&] {
    joined.attach(listener, kStart);
    auto* first = one.far;
    first->on_peer(who, PeerEvent::kUp);
    other.far->on_peer(who, PeerEvent::kUp);
    other.far->on_subscribe(kFar, {1, pattern("a"), {}});
    other.far->on_summary(kFar, "{}");
    return first;
  };
  meet()->on_changes(kFar, std::vector<Change>{SnapshotEnd{1}, restart(1), SnapshotEnd{1}});
  meet()->on_remote_set(command);
  meet()->on_subscribe(kFar, {1, pattern("a"), {}});
  meet()->on_peer(who, PeerEvent::kLost);  // it moves: the summary is reported
  EXPECT_EQ(listener.calls, 4);
  for (int at = 1; at <= 3; ++at) {
    listener.leave_at = 100;
    auto* first = meet();
    listener.peers = 0;
    listener.leave_at = at;
    first->on_peer(restarted, PeerEvent::kUp);
  }
  EXPECT_EQ(listener.calls, 7);
  EXPECT_THAT(joined.peers(), IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::joined
