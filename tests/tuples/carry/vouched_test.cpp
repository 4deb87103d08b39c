#include "support/rights.h"
#include "tuples/carry/carrying.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using support::Right;
using support::rule;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A lamp (7) with rights on one engine, where the carrier (1) is the member `hall`; on the other one `desk` (8) and a
/// stranger (9). Each engine is judged by its owner, as real ones are.
struct Vouched : testing::Test {
  static constexpr OwnerId kLamp{7};

  void judge_by(std::vector<rights::Rule> of_owner, std::vector<rights::Rule> of_carrier) {
    near.judge(kLamp, support::judge_of(std::move(of_owner), audit));
    far.judge(kLamp, support::judge_of(std::move(of_carrier), nullptr));
    for (const auto id : {1, 8, 9}) near.certify(OwnerId(id), {.name = "hall"});
    far.certify(OwnerId(8), {.name = "desk"});
    far.certify(OwnerId(9), {.name = "user:bob"});
    time.run_for(1s);
    carrier = std::make_unique<Carrier>(OwnerId(1), rules_of({"7"}),
                                        std::vector<Carrier::Engine>{{"near", near}, {"far", far}}, time, log);
    both = std::make_unique<joined::JoinedEcology>(
        std::vector<joined::JoinedEcology::Engine>{{"near", carrier->engine(0)}, {"far", carrier->engine(1)}}, time,
        log);
    island = std::make_unique<Observer>(*both, time, 1);
    lamp = std::make_unique<Home>(near, time, 7);
    time.run_for(1s);
    desk = std::make_unique<Observer>(far, time, 8);
    stranger = std::make_unique<Observer>(far, time, 9);
    time.run_for(5s);
  }
  Reply set(Observer& by, std::string_view key = "hall.lamp", const SetOptions& options = {}) {
    Reply answer{{}, 0, Verdict::kExpired, {}, "none", 0};
    by.space.set_remote(
        kLamp, key, "on", 10s, [&](const Reply& reply) { answer = reply; }, options);
    time.run_for(6s);
    return answer;
  }
  static rights::Rule vouch(std::string who, std::string names) {
    auto made = rule(std::move(who), {});
    made.names = {std::move(names)};
    return made;
  }
  static rights::Rule all_of_carrier() { return rule("everybody", {Right::kRead, Right::kDemand, Right::kSet}); }

  VirtualScheduler time;
  support::CollectingLog log;
  std::shared_ptr<support::CollectingAudit> audit = std::make_shared<support::CollectingAudit>();
  MemoryEcology near{time, "here"}, far{time, "there"};
  std::unique_ptr<Carrier> carrier;
  std::unique_ptr<joined::JoinedEcology> both;
  std::unique_ptr<Observer> island, desk, stranger;
  std::unique_ptr<Home> lamp;
};

TEST_F(Vouched, WithoutARuleTheOwnerJudgesTheCarrier) {
  judge_by({rule("hall", {Right::kSet}), rule("member:desk@hall", {}, {"**"}, {"**"})}, {all_of_carrier()});
  EXPECT_EQ(set(*desk).verdict, Verdict::kApplied);
  EXPECT_THAT(audit->lines, ElementsAre("hall set hall.lamp: accepted"));
  EXPECT_EQ(lamp->sets.back().asker, "member:desk") << "it is named all the same";
}

TEST_F(Vouched, WithARuleTheOwnerJudgesWhomTheCarrierNames) {
  judge_by({vouch("member:hall", "*"), rule("member:desk@hall", {Right::kSet}, {"hall.*"})}, {all_of_carrier()});
  EXPECT_EQ(set(*desk).verdict, Verdict::kApplied);
  const auto refused = set(*stranger);
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_THAT(refused.text, HasSubstr("user:bob@hall may not set hall.lamp: no rule allows it"));
  EXPECT_THAT(audit->lines,
              ElementsAre("member:desk@hall set hall.lamp: accepted", "user:bob@hall set hall.lamp: refused"));
  EXPECT_THAT(audit->throughs, ElementsAre("hall", "hall"));
}

TEST_F(Vouched, ARuleForUsersSaysNothingOfMembers) {
  judge_by({vouch("hall", "user:*"), rule("user:bob@hall", {Right::kSet})}, {all_of_carrier()});
  EXPECT_EQ(set(*stranger).verdict, Verdict::kApplied);
  EXPECT_THAT(set(*desk).text, HasSubstr("hall may not set hall.lamp")) << "judged as the carrier";
}

TEST_F(Vouched, NobodyTakesTheNameOfAnotherTowardsACarrier) {
  judge_by({vouch("hall", "*"), rule("member:desk@hall", {Right::kSet})}, {all_of_carrier()});
  EXPECT_EQ(set(*stranger, "hall.lamp", {.asker = "member:desk"}).verdict, Verdict::kRefused);
  EXPECT_THAT(audit->lines, ElementsAre("user:bob@hall set hall.lamp: refused"));
}

TEST_F(Vouched, NamesGrowBehindEachWhoVouches) {
  judge_by({vouch("hall", "*"), rule("token:tablet@desk@hall", {Right::kSet})},
           {all_of_carrier(), vouch("desk", "token:*")});
  EXPECT_EQ(set(*desk, "hall.lamp", {.asker = "token:tablet"}).verdict, Verdict::kApplied);
  EXPECT_THAT(audit->lines, ElementsAre("token:tablet@desk@hall set hall.lamp: accepted"));
}

TEST_F(Vouched, TheRightsOfTheCarrierComeFirst) {
  judge_by({rule("hall", {Right::kSet})}, {rule("desk", {Right::kSet}, {"hall.*"})});
  EXPECT_EQ(set(*desk).verdict, Verdict::kApplied);
  EXPECT_THAT(set(*stranger).text, HasSubstr("user:bob may not set hall.lamp: no rule allows it"));
  EXPECT_THAT(set(*desk, "kitchen.lamp").text, HasSubstr("desk may not set kitchen.lamp"));
  EXPECT_EQ(lamp->sets.size(), 1U);
}

/// Its owner would judge them as those of the carrier.
TEST_F(Vouched, MessagesDoNotPassACarrierWithRights) {
  judge_by({rule("hall", {Right::kSet})}, {all_of_carrier()});
  EXPECT_THAT(set(*desk, "GATEWAY").text, HasSubstr("component 1 has rights, and carries no messages"));
  EXPECT_THAT(lamp->sets, IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::carry
