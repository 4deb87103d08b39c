#include <gmock/gmock.h>

#include "tuples/peer_policy.h"
#include "tuples/peis/link_to_a_kernel.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// `peis` may see and set what begins with `open`.
struct GateJudge final : Judge {
  static bool is_open(const Member& who, std::string_view key) {
    return who.name == kPeisMember && key.starts_with("open");
  }
  Access access(const Member& who, std::string_view key) const override {
    return {is_open(who, key) && !closed, false, {}};
  }
  bool sees_all(const Member&) const override { return false; }
  Result<void> may_set(const Member& who, const RemoteSet& set) const override {
    if (is_open(who, set.key)) return {};
    return fail(ErrorCode::kRefused, who.name + " may not set " + set.key);
  }
  Result<void> may_send(const Member&, std::string_view) const override { return fail(ErrorCode::kRefused, "no"); }
  Result<void> may_by_names(const Member&, Act, std::span<const std::string>) const override {
    return fail(ErrorCode::kRefused, "no");
  }
  Handle speak_for(const Member&, OwnerId, std::uint64_t) override { return {}; }
  const Member* spoken_for(OwnerId, std::uint64_t) const override { return nullptr; }
  void record(const Member&, const OtherRequest&, const Result<void>&) override {}
  void answered(const Member& who, std::string_view, const RemoteSet& set, const Reply& reply) override {
    answers.push_back(who.name + " " + set.key + " " + std::string(to_string(reply.verdict)));
  }
  bool closed = false;
  std::vector<std::string> answers;
};

struct PeisRights : LinkToAKernel {
  PeisRights() : PeisRights(std::make_shared<GateJudge>()) {}
  explicit PeisRights(std::shared_ptr<GateJudge> gate) : LinkToAKernel(gate), judge(std::move(gate)) {}
  std::shared_ptr<GateJudge> judge;
};

TEST_F(PeisRights, AKernelSeesWhatTheRightsOfPeisSayAndNoOtherKey) {
  ASSERT_TRUE(space->set("open.a", "1"));
  ASSERT_TRUE(space->set("shut.a", "secret"));
  subscribe("*.a");
  subscribe("open.a");
  subscribe("shut.a");
  subscribe("kernel.all-keys");
  world.run(5s);
  std::string all_keys;
  std::vector<std::string> own;
  for (const auto& push : pushed()) {
    EXPECT_THAT(push.data, Not(HasSubstr("secret")));
    EXPECT_THAT(push.key, Not(HasSubstr("shut")));
    if (push.key == "kernel.all-keys") all_keys = push.data;
    if (push.key == "open.a") own.push_back(push.data);
  }
  EXPECT_FALSE(own.empty());
  EXPECT_THAT(all_keys, HasSubstr("open.a"));
  EXPECT_THAT(all_keys, Not(HasSubstr("shut")));
}

TEST_F(PeisRights, WhatIsTakenAwayIsDeletedAtTheKernel) {
  ASSERT_TRUE(space->set("open.a", "1"));
  subscribe("open.a");
  world.run(2s);
  EXPECT_THAT(own_pushed(), testing::Contains(HasSubstr("open.a=1")));
  judge->closed = true;
  SpaceRights::rejudge(*space);
  world.run(2s);
  EXPECT_THAT(own_pushed(), ElementsAre("open.a deleted"));
  ASSERT_TRUE(space->set("open.a", "2"));
  world.run(2s);
  EXPECT_THAT(own_pushed(), IsEmpty());
}

TEST_F(PeisRights, AKernelSetsWhatTheRightsOfPeisSay) {
  int sets = 0;
  const auto policy = space->add_policy(*Pattern::parse("**"), [&](const RemoteSet&) {
    ++sets;
    return SetDecision::applied();
  });
  set_remote("open.x", c_string("1"));
  set_remote("shut.x", c_string("1"));
  world.run(2s);
  EXPECT_EQ(sets, 1);
  EXPECT_THAT(judge->answers, ElementsAre("peis open.x applied", "peis shut.x refused"));
}

TEST_F(PeisRights, WithoutRightsToDemandAKernelWakesNothing) {
  ASSERT_TRUE(space->set("open.a", "1"));
  int wanted = 0;
  const auto watch = space->watch_demand(*Pattern::parse("**"), [&](const Demand&) { ++wanted; });
  subscribe("open.a");
  world.run(2s);
  EXPECT_THAT(own_pushed(), testing::Contains(HasSubstr("open.a=1")));
  EXPECT_EQ(wanted, 0);
}

}  // namespace
}  // namespace rubicon::tuples::peis
