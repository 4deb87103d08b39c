#include "tuples/peer_policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// Refuses what its test says, and writes down what it is asked.
struct Doorkeeper final : OpenPolicy {
  Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) override {
    asked.push_back(std::to_string(number(peer)) + " subscribes " + spec.pattern.key);
    return answer("subscribing");
  }
  Result<void> may_set(const RemoteSet& set) override {
    asked.push_back(std::to_string(number(set.from)) + " sets " + set.key);
    return answer("setting");
  }
  Result<void> answer(const std::string& doing) const {
    if (open) return {};
    return fail(ErrorCode::kRefused, doing + ": the door is closed");
  }

  bool open = true;
  std::vector<std::string> asked;
};

/// A link of the engine with another policy.
struct GuardedLink final : Link {
  GuardedLink(std::unique_ptr<Link> inside, PeerPolicy& a_policy) : link(std::move(inside)), guard(a_policy) {}
  void attach(LinkListener& listener, std::uint64_t incarnation) override { link->attach(listener, incarnation); }
  void detach() override { link->detach(); }
  bool publish(OwnerId to, std::span<const Change> changes) override { return link->publish(to, changes); }
  void subscribe(const SubscriptionSpec& spec) override { link->subscribe(spec); }
  void unsubscribe(std::uint32_t id) override { link->unsubscribe(id); }
  Result<void> remote_set(const RemoteSet& set) override { return link->remote_set(set); }
  void reply(const Reply& reply) override { link->reply(reply); }
  void describe(std::string summary) override { link->describe(std::move(summary)); }
  std::vector<OwnerId> peers() const override { return link->peers(); }
  PeerPolicy& policy() override { return guard; }

  std::unique_ptr<Link> link;
  PeerPolicy& guard;
};

/// An island (1) with a doorkeeper, and a robot (70000).
struct Policy : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(space.set("a", "1"));
    time.run_for(1s);
  }
  Reply set(std::string_view key) {
    Reply answer;
    robot.space.set_remote(OwnerId(1), key, "2", 60s, [&](const Reply& reply) { answer = reply; });
    time.run_for(1s);
    return answer;
  }

  VirtualScheduler time;
  TestEcology ecology{time};
  Doorkeeper doorkeeper;
  GuardedLink link{std::move(*ecology.join(OwnerId(1))), doorkeeper};
  TupleSpace space{OwnerId(1), time, link};
  Component robot{ecology, time, 70000};
  Handle policy = space.add_policy(pattern("a"), [](const RemoteSet&) { return SetDecision::applied(); });
  Listener seen;
};

TEST_F(Policy, IsAskedOncePerSubscriptionAndSetAndNeverPerPublication) {
  const auto handle = robot.space.subscribe(pattern("a"), {}, seen.call());
  time.run_for(1s);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(space.set("a", std::to_string(i)));
    time.run_for(10ms);
  }
  EXPECT_GT(seen.seen.size(), 1U);
  EXPECT_EQ(set("a").verdict, Verdict::kApplied);
  EXPECT_THAT(doorkeeper.asked, ElementsAre("70000 subscribes a", "70000 sets a"));
  EXPECT_EQ(space.stats().refused, 0U);
}

TEST_F(Policy, RefusesWithItsReasonAndIsCounted) {
  doorkeeper.open = false;
  const auto handle = robot.space.subscribe(pattern("a"), {}, seen.call());
  time.run_for(1s);
  EXPECT_THAT(seen.seen, IsEmpty());
  const auto answer = set("a");
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_EQ(answer.text, "setting: the door is closed");
  EXPECT_EQ(space.get(OwnerId(1), "a")->value, "1");
  EXPECT_EQ(space.stats().refused, 2U);
}

}  // namespace
}  // namespace rubicon::tuples
