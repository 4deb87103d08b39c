#include "tuples/link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr OwnerId kObserver{1}, kReader{70000};
/// 2027-01-15 UTC.
constexpr std::uint64_t kStart = 1'800'000'000'000'000;

/// Writes down what a link brings, starts as microseconds after kStart.
struct LinkDiary final : LinkListener {
  void on_changes(OwnerId, std::span<const Change> changes) override {
    for (const auto& change : changes) note(change);
  }
  void note(const Change& change) {
    if (const auto* set = std::get_if<TupleSet>(&change)) seen.push_back("set " + std::string(set->tuple.key));
    if (const auto* end = std::get_if<SnapshotEnd>(&change)) seen.push_back("end " + std::to_string(end->subscription));
    if (const auto* restart = std::get_if<Restart>(&change)) {
      EXPECT_GT(restart->since, last_restart);
      last_restart = restart->since;
      seen.emplace_back("restart");
    }
  }
  void on_subscribe(OwnerId, const SubscriptionSpec&) override {}
  void on_unsubscribe(OwnerId, std::uint32_t) override {}
  void on_remote_set(const RemoteSet&) override {}
  bool on_reply(OwnerId, const Reply&) override { return true; }
  void on_peer(const PeerIdentity& peer, PeerEvent event) override {
    EXPECT_FALSE(peer.host.empty());
    const auto name = event == PeerEvent::kUp ? "up " : event == PeerEvent::kLeft ? "left " : "lost ";
    seen.push_back(name + std::to_string(peer.incarnation - kStart));
  }
  void on_summary(OwnerId, std::string_view) override {}
  Seen take() { return std::exchange(seen, {}); }

  Seen seen;
  WallTime last_restart{};
};

struct LinkOfAnEngine : testing::Test {
  Seen after_a_second(LinkDiary& diary) {
    time.run_for(1s);
    return diary.take();
  }

  VirtualScheduler time;
  TestEcology ecology{time};
  LinkDiary diary, other;
};

TEST_F(LinkOfAnEngine, ShowsTheStartThatItsListenerGave) {
  const auto observer = std::move(*ecology.join(kObserver));
  const auto link = std::move(*ecology.join(kReader));
  observer->attach(diary, kStart);
  time.run_for(1s);
  for (const auto* start : {"5", "6", "7"}) {
    link->attach(other, kStart + 5);  // a number that it had takes the next
    EXPECT_THAT(after_a_second(diary), ElementsAre("up " + std::string(start)));
    link->detach();
    EXPECT_THAT(after_a_second(diary), ElementsAre("left " + std::string(start)));
  }
  observer->detach();
}

TEST_F(LinkOfAnEngine, BringsTheSnapshotAgainWhenASubscriptionIsRepeated) {
  Component island(ecology, time, 1);
  ASSERT_TRUE(island.space.set("x", "1"));
  const auto link = std::move(*ecology.join(kReader));
  link->attach(other, kStart);
  after_a_second(other);
  const SubscriptionSpec spec{9, pattern("1:x"), {}};
  link->subscribe(spec);
  EXPECT_THAT(after_a_second(other), ElementsAre("restart", "set x", "end 9"));
  link->subscribe(spec);
  EXPECT_THAT(after_a_second(other), ElementsAre("set x", "end 9"));
  link->detach();
  link->attach(other, kStart);
  link->subscribe(spec);
  EXPECT_THAT(after_a_second(other), testing::IsSupersetOf({"restart", "set x", "end 9"}))
      << "the restart is a later one";
}

}  // namespace
}  // namespace rubicon::tuples
