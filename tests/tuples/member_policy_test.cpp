#include "tuples/peer_policy.h"

#include <gtest/gtest.h>

namespace rubicon::tuples {
namespace {

/// Members may do everything; counts the answers.
struct OpenJudge final : Judge {
  Access access(const Member&, std::string_view) const override { return {}; }
  bool sees_all(const Member&) const override { return true; }
  Result<void> may_set(const Member&, const RemoteSet&) const override { return {}; }
  Result<void> may_send(const Member&, std::string_view) const override { return {}; }
  Result<void> may_by_names(const Member&, Act, std::span<const std::string>) const override { return {}; }
  bool may_vouch(const Member& who, std::string_view name) const override {
    return who.name == "member:hall" || (who.name == "robot" && name == "user:ann");
  }
  Handle speak_for(const Member&, OwnerId, std::uint64_t) override { return {}; }
  const Member* spoken_for(OwnerId, std::uint64_t) const override { return nullptr; }
  void record(const Member&, const OtherRequest&, const Result<void>&) override {}
  void answered(const Member& who, std::string_view, const RemoteSet&, const Reply&) override {
    ++answers;
    last = who;
  }
  int answers = 0;
  Member last;
};

PeerIdentity peer(std::uint32_t id, std::shared_ptr<const Member> member, bool own_process = false) {
  return {OwnerId(id), 1, "host", std::move(member), own_process};
}

struct PolicyOfMembers : testing::Test {
  RemoteSet set_by(std::uint32_t id) const {
    RemoteSet set;
    set.from = OwnerId(id);
    set.key = "a";
    return set;
  }
  std::shared_ptr<OpenJudge> judge = std::make_shared<OpenJudge>();
  MemberPolicy policy{OwnerId(1), judge};
  std::shared_ptr<const Member> robot =
      std::make_shared<const Member>(Member{.name = "robot", .ids = {{70000, 70009}}});
};

TEST_F(PolicyOfMembers, OnlyMembersMayJoinWithTheirIds) {
  EXPECT_TRUE(policy.may_join(peer(70000, robot)));
  EXPECT_EQ(policy.may_join(peer(70010, robot)).error().text,
            "component 70010 is of member 'robot', who does not have that id");
  EXPECT_EQ(policy.may_join(peer(70000, nullptr)).error().text,
            "component 70000 is not authenticated, expected a member");
  EXPECT_TRUE(policy.may_join(peer(70000, nullptr, true)));
}

TEST_F(PolicyOfMembers, OnlyWhoIsKnownByTheWireAloneHasAnyId) {
  const auto joins = [this](Member member) {
    return policy.may_join(peer(70000, std::make_shared<const Member>(std::move(member)))).has_value();
  };
  EXPECT_TRUE(joins({.name = "peis"}));
  EXPECT_TRUE(joins({.name = "lan"}));
  EXPECT_FALSE(joins({.name = "robot"})) << "a member without ids";
}

TEST_F(PolicyOfMembers, WhoIsNotUpMayNothing) {
  EXPECT_TRUE(policy.filters(OwnerId(70000)));
  EXPECT_EQ(policy.access(OwnerId(70000), "a"), (Access{false, false, Duration(0)}));
  EXPECT_FALSE(policy.may_set(set_by(70000)));
  EXPECT_FALSE(policy.may_send(OwnerId(70000), "own"));
  EXPECT_FALSE(policy.may_subscribe(OwnerId(70000), {}));
  EXPECT_EQ(policy.host(OwnerId(70000)), "");
  policy.peer_up(peer(70000, robot));
  EXPECT_EQ(policy.host(OwnerId(70000)), "host");
  EXPECT_FALSE(policy.filters(OwnerId(70000)));
  EXPECT_TRUE(policy.may_set(set_by(70000)));
  EXPECT_TRUE(policy.may_send(OwnerId(70000), "own"));
  policy.peer_down(OwnerId(70000));
  EXPECT_FALSE(policy.may_set(set_by(70000)));
  EXPECT_EQ(policy.member(OwnerId(70000)), nullptr);
}

TEST_F(PolicyOfMembers, RequestsOfTheOwnProcessAreNotReported) {
  policy.peer_up(peer(70000, robot));
  policy.peer_up(peer(70001, robot, true));
  policy.answered(set_by(70001), {});
  policy.answered(set_by(1), {});
  EXPECT_EQ(judge->answers, 0);
  policy.answered(set_by(70000), {});
  EXPECT_EQ(judge->answers, 1);
}

TEST_F(PolicyOfMembers, WhoMayVouchForANameIsNotJudgedItself) {
  policy.peer_up(peer(70000, robot));
  auto set = set_by(70000);
  EXPECT_EQ(policy.asker(set)->name, "robot");
  set.asker = "user:ann";
  EXPECT_EQ(policy.asker(set)->name, "user:ann@robot");
  EXPECT_EQ(policy.asker(set)->through, "robot");
  policy.answered(set, {});
  EXPECT_EQ(judge->last.name, "user:ann@robot") << "for the audit";
  set.asker = "user:bob";
  EXPECT_EQ(policy.asker(set)->name, "robot") << "without a rule the sender is judged";
  policy.answered(set, {});
  EXPECT_EQ(judge->last.name, "robot");
  policy.peer_up(peer(70001, robot, true));
  auto own = set_by(70001);
  own.asker = "user:ann";
  EXPECT_EQ(policy.asker(own), nullptr) << "of this process";
  EXPECT_EQ(policy.asker(set_by(70002)), nullptr);
}

TEST_F(PolicyOfMembers, TheLinkItselfGetsNothingUnlessSomebodyStandsBehindIt) {
  EXPECT_TRUE(policy.filters(kLinkItself));
  EXPECT_FALSE(policy.access(kLinkItself, "a").read);
  const MemberPolicy with_peis{OwnerId(1), judge, robot};
  EXPECT_TRUE(with_peis.access(kLinkItself, "a").read);
}

}  // namespace
}  // namespace rubicon::tuples
