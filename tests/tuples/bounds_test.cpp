#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tuples/component.h"
#include "tuples/event_queue.h"
#include "tuples/outbox.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// A link whose other end is played by the test.
struct ScriptedLink final : Link {
  void attach(LinkListener& to, std::uint64_t) override { listener = &to; }
  void detach() override { listener = nullptr; }
  bool publish(OwnerId, std::span<const Change> changes) override {
    ++attempts;
    if (full) return false;
    frames.push_back(changes.size());
    for (const auto& change : changes) {
      if (std::holds_alternative<Restart>(change)) {
        ++restarts;
      } else if (const auto* end = std::get_if<SnapshotEnd>(&change)) {
        sent.push_back("end " + std::to_string(end->subscription));
      } else if (const auto* gone = std::get_if<TupleGone>(&change)) {
        sent.push_back(std::string(gone->key) + " " + std::string(to_string(gone->how)));
      } else {
        const auto& tuple = std::get<TupleSet>(change).tuple;
        sent.push_back(std::string(tuple.key) + "=" + std::string(tuple.value));
      }
    }
    return true;
  }
  void subscribe(const SubscriptionSpec& spec) override { subscribed.push_back(spec.id); }
  void unsubscribe(std::uint32_t) override {}
  Result<void> remote_set(const RemoteSet&) override {
    return takes_sets ? Result<void>() : fail(ErrorCode::kBusy, "the window is full");
  }
  void reply(const Reply& reply) override { replies.push_back(reply); }
  void describe(std::string) override {}
  std::vector<OwnerId> peers() const override { return {}; }
  PeerPolicy& policy() override { return open; }

  OpenPolicy open;
  LinkListener* listener = nullptr;
  bool full = false, takes_sets = false;
  int attempts = 0, restarts = 0;
  std::vector<std::uint32_t> subscribed;
  std::vector<std::size_t> frames;
  Seen sent;
  std::vector<Reply> replies;
};

TEST(OutboxOfOneWhoLeft, NeedsNoMemory) {
  ScriptedLink link;
  Store store(OwnerId(1));
  Outbox outbox(store, link, [](const PeerQueue&, std::uint32_t) { return true; });
  PeerQueue peer;
  for (int i = 0; i < 1000; ++i) outbox.add(peer, store.create(OwnerId(1), "t.k" + std::to_string(i)));
  EXPECT_EQ(outbox.size(), 1000U);
  outbox.close(peer);
  EXPECT_EQ(outbox.size(), 0U);
  EXPECT_TRUE(outbox.empty());
  EXPECT_EQ(peer.entries.capacity() + peer.queued.capacity(), 0U);
}

constexpr OwnerId kPeer{70000};

struct Bounds : testing::Test {
  TupleSet change(std::string_view key, std::string_view value, std::uint64_t sequence) {
    TupleSet made;
    made.tuple.key = key;
    made.tuple.value = value;
    made.tuple.sequence = sequence;
    made.tuple.media_type = "text/plain";
    return made;
  }
  void receive(const Change& one) {
    link.listener->on_changes(kPeer, std::span(&one, 1));
    time.run_ready();
  }
  VirtualScheduler time;
  ScriptedLink link;
  TupleSpace space{OwnerId(1), time, link};
  Listener listener;
};

TEST_F(Bounds, WhoWasLostToTheOwnerOnlyStillLearnsWhatWasDeletedMeanwhile) {
  const auto handle = space.subscribe(pattern("**"), {}, listener.call());
  time.run_ready();
  receive(change("kept", "1", 1));
  receive(change("gone", "1", 1));
  receive(SnapshotEnd{link.subscribed.back()});
  // The owner saw us go and come back; to us it was always there.
  receive(Restart{});
  receive(change("kept", "1", 1));
  EXPECT_TRUE(space.get(kPeer, "gone")) << "the snapshot is not complete yet";
  receive(SnapshotEnd{link.subscribed.back()});
  time.run_for(1s);
  EXPECT_TRUE(space.get(kPeer, "kept"));
  EXPECT_FALSE(space.get(kPeer, "gone"));
}

TEST_F(Bounds, ANewOrReturningSubscriberReceivesARestartFirst) {
  link.listener->on_subscribe(kPeer, {9, pattern("a"), {}});
  link.listener->on_subscribe(kPeer, {10, pattern("b"), {}});
  time.run_ready();
  EXPECT_EQ(link.restarts, 1);
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kUp);
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kLost);
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kUp);
  link.listener->on_subscribe(kPeer, {9, pattern("a"), {}});
  time.run_ready();
  EXPECT_EQ(link.restarts, 2);
}

TEST_F(Bounds, ASlowSubscriberGetsTheLatestOnceThereIsRoom) {
  link.listener->on_subscribe(kPeer, {9, pattern("**"), {}});
  time.run_ready();
  EXPECT_THAT(std::exchange(link.sent, {}), ElementsAre("end 9"));
  link.full = true;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(space.set("a", std::to_string(i)));
    ASSERT_TRUE(space.set("b", std::to_string(i)));
    time.run_ready();
  }
  ASSERT_TRUE(space.erase("b"));
  EXPECT_LT(link.attempts, 10);
  EXPECT_EQ(space.stats().merged, 199u);
  time.run_for(100ms);
  EXPECT_THAT(link.sent, IsEmpty());
  link.full = false;
  time.run_for(1ms);
  EXPECT_THAT(link.sent, ElementsAre("a=99", "b deleted"));
  EXPECT_EQ(space.stats().queued, 0u);
}

TEST_F(Bounds, FramesAreLimitedAndTheSnapshotEndsWithItsNumber) {
  for (int i = 0; i < 20'000; ++i) ASSERT_TRUE(space.set("a.t" + std::to_string(i), "x"));
  link.listener->on_subscribe(kPeer, {3, pattern("a.*"), {}});
  time.run_ready();
  EXPECT_EQ(link.sent.size(), 20'001u);
  EXPECT_EQ(link.sent.back(), "end 3");
  for (const auto size : link.frames) EXPECT_LE(size, 512u);
}

TEST_F(Bounds, WhatWaitsForALostSubscriberIsForgotten) {
  link.full = true;
  link.listener->on_subscribe(kPeer, {3, pattern("**"), {}});
  ASSERT_TRUE(space.set("a", "1"));
  time.run_ready();
  EXPECT_EQ(space.stats().queued, 3u);
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kLost);
  EXPECT_EQ(space.stats().queued, 0u);
  link.full = false;
  time.run_for(1s);
  EXPECT_THAT(link.sent, IsEmpty());
}

/// One that subscribes and unsubscribes, but reads nothing.
TEST_F(Bounds, EndsOfSnapshotsThatWaitAreBounded) {
  constexpr std::uint32_t kFirst = 1, kLast = 60'000, kLive = 7;
  link.full = true;
  ASSERT_TRUE(space.set("a", "1"));
  link.listener->on_subscribe(kPeer, {kLive, pattern("a"), {}});
  for (auto id = kFirst; id <= kLast; ++id) {
    if (id == kLive) continue;
    link.listener->on_subscribe(kPeer, {id, pattern("b"), {}});
    if (id < kLast) link.listener->on_unsubscribe(kPeer, id);
    if (id % 100 == 0) time.run_ready();
  }
  time.run_ready();
  EXPECT_LE(space.stats().queued, Outbox::kMaxControls + 1);
  EXPECT_GT(space.stats().merged, 0u);
  link.full = false;
  time.run_for(1s);
  EXPECT_EQ(link.restarts, 1);
  EXPECT_EQ(std::count(link.sent.begin(), link.sent.end(), "end 7"), 1) << "that of a live subscription is kept";
  EXPECT_EQ(link.sent.front(), "a=1");
  EXPECT_EQ(link.sent.back(), "end 60000");
  EXPECT_EQ(space.stats().queued, 0u);
}

TEST_F(Bounds, OfTheEndsOfASubscriptionSentAgainTheLastCounts) {
  link.full = true;
  for (int i = 0; i < 60'000; ++i) link.listener->on_subscribe(kPeer, {9, pattern("**"), {}});
  ASSERT_TRUE(space.set("late", "1"));
  link.listener->on_subscribe(kPeer, {9, pattern("**"), {}});
  time.run_ready();
  EXPECT_LE(space.stats().queued, Outbox::kMaxControls + 1);
  link.full = false;
  time.run_for(1s);
  EXPECT_EQ(link.sent.back(), "end 9") << "after the tuple that the last snapshot has";
  EXPECT_LE(link.sent.size(), Outbox::kMaxControls);
}

TEST_F(Bounds, RepeatedAndOldChangesAreDropped) {
  const auto handle = space.subscribe(pattern("**"), {}, listener.call());
  receive(change("a", "5", 5));
  receive(change("a", "5", 5));
  receive(change("a", "4", 4));
  receive(change("a", "6", 6));
  EXPECT_THAT(listener.take(), ElementsAre("a=5", "a=6"));
}

TEST_F(Bounds, HostileChangesAreCountedAndDropped) {
  const auto handle = space.subscribe(pattern("**"), {}, listener.call());
  const std::string long_key(10'240, 'k'), huge(2'000'000, 'x');
  for (const auto& key : {std::string("a..b"), std::string("a\nb"), std::string("**"), long_key}) {
    receive(change(key, "x", 1));
  }
  receive(change("a", huge, 1));
  receive(change("a", "x", 0));
  const Change mine = change("a", "x", 1);
  link.listener->on_changes(OwnerId(1), std::span(&mine, 1));
  auto odd = change("odd", "x", 1);
  odd.tuple.media_type = huge;
  odd.tuple.write_time = WallTime(std::chrono::microseconds::min());
  odd.tuple.expire_time = WallTime(std::chrono::microseconds::max());
  receive(odd);
  std::swap(odd.tuple.write_time, odd.tuple.expire_time);
  odd.tuple.sequence = 2;
  receive(odd);
  time.run_for(1s);
  EXPECT_THAT(listener.take(), ElementsAre("odd=x", "odd=x", "odd expired"));
  EXPECT_EQ(space.stats().dropped, 7u);
  EXPECT_EQ(space.stats().cached, 0u);
}

TEST_F(Bounds, ChangesNobodyAskedForAreNotKept) {
  receive(change("a", "x", 1));
  EXPECT_EQ(space.stats().cached, 0u);
  EXPECT_FALSE(space.get(kPeer, "a"));
}

TEST_F(Bounds, HostileSubscriptionsAreCountedAndDropped) {
  for (const auto* key : {"", "a..b", "**.a", "a:b", "a b"}) {
    link.listener->on_subscribe(kPeer, {1, {std::nullopt, key}, {}});
  }
  EXPECT_EQ(space.stats().dropped, 5u);
  for (std::uint32_t i = 0; i < 10'010; ++i) link.listener->on_subscribe(kPeer, {i, pattern("x.y"), {}});
  EXPECT_EQ(space.stats().subscriptions, 10'000u);
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kLeft);
  time.run_ready();
  EXPECT_EQ(space.stats().subscriptions, 0u);
}

TEST_F(Bounds, ManySubscribersOfOneTupleAreTakenOffInSlices) {
  ASSERT_TRUE(space.set("a", "1"));
  for (std::uint32_t i = 0; i < 2'000; ++i) link.listener->on_subscribe(kPeer, {i, pattern("a"), {}});
  ASSERT_TRUE(space.erase("a"));
  const auto again = *space.set("a", "2");
  EXPECT_TRUE(space.has_subscriber(again));
  link.listener->on_peer({kPeer, 1, "host"}, PeerEvent::kLeft);
  EXPECT_FALSE(space.has_subscriber(again));
  time.run_ready();
  ASSERT_TRUE(space.set(again, "3"));
  time.run_ready();
  EXPECT_EQ(space.stats().queued, 0u);
}

TEST_F(Bounds, ASubscriptionSentAgainReplacesItself) {
  ASSERT_TRUE(space.set("a", "1"));
  for (int i = 0; i < 3; ++i) link.listener->on_subscribe(kPeer, {1, pattern("a"), {}});
  EXPECT_EQ(space.stats().subscriptions, 1u);
  link.listener->on_unsubscribe(kPeer, 1);
  link.listener->on_unsubscribe(kPeer, 2);
  EXPECT_EQ(space.stats().subscriptions, 0u);
  EXPECT_FALSE(space.has_subscriber(*space.find("a")));
}

TEST_F(Bounds, AnExpiredRemoteSetDoesNotReachThePolicy) {
  bool decided = false;
  const auto policy = space.add_policy(pattern("a"), [&](const RemoteSet&) {
    decided = true;
    return SetDecision::applied();
  });
  RemoteSet set;
  set.from = kPeer;
  set.key = "a";
  set.time_to_live = -1ns;
  link.listener->on_remote_set(set);
  ASSERT_EQ(link.replies.size(), 1u);
  EXPECT_EQ(link.replies[0].verdict, Verdict::kExpired);
  EXPECT_FALSE(decided);
}

TEST_F(Bounds, AFullWindowRefusesBusy) {
  std::vector<Reply> replies;
  space.set_remote(kPeer, "a", "1", 1s, [&](const Reply& reply) { replies.push_back(reply); });
  time.run_for(1h);
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].verdict, Verdict::kRefused);
  EXPECT_EQ(replies[0].code, ErrorCode::kBusy);
}

TEST_F(Bounds, AReplyOfAnotherThanTheOwnerDoesNotCount) {
  link.takes_sets = true;
  std::vector<Reply> replies;
  const auto request = space.set_remote(kPeer, "a", "1", 1h, [&](const Reply& reply) { replies.push_back(reply); });
  time.run_ready();
  EXPECT_FALSE(link.listener->on_reply(OwnerId(70001), {OwnerId(1), request, Verdict::kApplied, {}, {}}));
  EXPECT_TRUE(replies.empty());
  EXPECT_EQ(space.stats().dropped, 1u);
  EXPECT_TRUE(link.listener->on_reply(kPeer, {OwnerId(1), request, Verdict::kApplied, {}, {}}));
  EXPECT_EQ(replies.size(), 1u);
}

TEST_F(Bounds, RepliesToNobodyAreIgnored) {
  EXPECT_TRUE(link.listener->on_reply(kPeer, {OwnerId(1), 77, Verdict::kApplied, {}, {}}));
  EXPECT_EQ(space.stats().dropped, 0u);
}

TEST(EventQueue, MergesToTheLatestOfATupleBeyondItsLimit) {
  Store store(OwnerId(1));
  EventQueue queue(store, 3);
  Listener listener;
  auto subscription = std::make_shared<Subscription>();
  subscription->number = 1;
  subscription->pattern = pattern("**");
  subscription->call = listener.call();
  store.add(subscription);
  const auto a = store.create(OwnerId(1), "a");
  const auto b = store.create(OwnerId(1), "b");
  for (int i = 0; i < 10; ++i) {
    for (const auto index : {a, b}) store.set_value(store.at(index), std::to_string(i));
    queue.push(a, EventKind::kSet);
    queue.push(b, EventKind::kSet);
  }
  queue.push(a, EventKind::kDeleted);
  store.remove(a, EventKind::kDeleted);
  EXPECT_EQ(queue.merged(), 15u);
  EXPECT_EQ(queue.dropped(), 0u);
  queue.drain(100);
  EXPECT_THAT(listener.take(), ElementsAre("a=0", "b=0", "a=1", "b=9", "a=9", "a deleted"));
  queue.push(b, EventKind::kSet);
  queue.drain(100);
  EXPECT_THAT(listener.take(), ElementsAre("b=9"));
}

TEST(EventQueue, DropsAndCountsWhatCannotBeMerged) {
  Store store(OwnerId(1));
  EventQueue queue(store, 2);
  Listener listener;
  auto subscription = std::make_shared<Subscription>();
  subscription->number = 1;
  subscription->pattern = pattern("**");
  subscription->call = listener.call();
  store.add(subscription);
  for (int i = 0; i < 6; ++i) {
    const auto index = store.create(OwnerId(1), "t" + std::to_string(i));
    queue.push(index, EventKind::kSet);
    queue.push_to(index, EventKind::kSet, subscription);
  }
  EXPECT_EQ(queue.size(), 4u);
  EXPECT_EQ(queue.dropped(), 8u);
  queue.drain(1);
  EXPECT_EQ(listener.take().size(), 1u);
  queue.drain(100);
  EXPECT_EQ(listener.take().size(), 3u);
}

}  // namespace
}  // namespace rubicon::tuples
