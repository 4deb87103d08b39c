#include <array>

#include "tuples/carry/wires.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// A stand-in of component 7 at a broker, of a user who carries it; a reader (8). The component itself comes later, as
/// another user or the same one.
struct AtABroker : testing::TestWithParam<std::string> {
  VirtualScheduler time;
  support::CollectingLog log;
  BrokerWire wire{time, log};
};

TEST_P(AtABroker, AStandInGivesWayToItsComponentAndEndsNobody) {
  auto carrier = wire.enter("hall");
  const auto link = std::move(*carrier.engine->join_as({OwnerId(7), marked_host("far", OwnerId(1)), {}}));
  TupleSpace stand_in(OwnerId(7), time, *link);
  ASSERT_TRUE(stand_in.set("x", "carried"));
  Listener seen;
  const Site<> reader(time, log, 8, {{"mqtt", &wire}});
  const auto handle = reader->space.subscribe(pattern("7:x"), {}, seen.call());
  time.run_for(5s);
  ASSERT_EQ(reader->value(7, "x"), "carried");

  auto entered = wire.enter(GetParam());
  std::vector<OwnerId> displaced;
  static_cast<mqtt::MqttEcology&>(*entered.engine).watch_displaced([&](OwnerId id) { displaced.push_back(id); });
  const auto own = std::move(*entered.engine->join(OwnerId(7)));
  TupleSpace itself(OwnerId(7), time, *own);
  ASSERT_TRUE(itself.set("x", "mine"));
  time.run_for(60s);
  EXPECT_THAT(seen.take(), ElementsAre("x=carried", "x=mine"));
  EXPECT_THAT(displaced, IsEmpty()) << "although it began later";
}

/// Who may use which ids, without a file.
class GivenRealm final : public UserRealm {
 public:
  explicit GivenRealm(std::map<std::string, std::vector<IdRange>, std::less<>> ids) {
    for (auto& [user, own] : ids) members_[user] = std::make_shared<Member>(Member{.name = user, .ids = own});
  }
  std::shared_ptr<const Member> member(std::string_view user) const override {
    const auto found = members_.find(user);
    return found == members_.end() ? nullptr : found->second;
  }
  const std::string& document() const override { return document_; }
  Taken take(std::string_view, std::string_view) override { return Taken::kOlder; }
  Handle watch(std::function<void()> call) override {
    watches_.push_back(std::move(call));
    return {};
  }
  void give(const std::string& user, const std::vector<IdRange>& ids) {
    members_[user] = std::make_shared<Member>(Member{.name = user, .ids = ids});
    for (const auto& call : watches_) call();
  }

 private:
  std::map<std::string, std::shared_ptr<const Member>, std::less<>> members_;
  std::string document_ = "given";
  std::vector<std::function<void()>> watches_;
};

/// A broker as one user enters it.
struct RealmWire final : Wire {
  RealmWire(BrokerWire& wire, std::string name, std::shared_ptr<UserRealm> its_realm)
      : all(wire), user(std::move(name)), realm(std::move(its_realm)) {}
  Entered enter() override { return all.enter(user, realm); }

  BrokerWire& all;
  std::string user;
  std::shared_ptr<UserRealm> realm;
};

/// A robot (7) on DDS, and three islands that carry it to the broker; the first one may not use its id there.
struct CarriersInARealm : testing::Test {
  using Island = std::unique_ptr<Site<>>;

  void SetUp() override {
    CarryRules rules{{{}}};
    ASSERT_TRUE(add_entry(rules.rules[0], "7"));
    for (auto& [wire, id, island] :
         {std::tie(of_attic, ids[0], attic), std::tie(of_hall, ids[1], hall), std::tie(of_lab, ids[2], lab)})
      island = std::make_unique<Site<>>(time, log, id, Site<>::On{{"dds", &dds}, {"mqtt", &wire}}, rules);
    robot = std::make_unique<Site<Home>>(time, log, 7, Site<Home>::On{{"dds", &dds}});
    desk = std::make_unique<Site<>>(time, log, 8, Site<>::On{{"mqtt", &of_desk}});
    copies = (*desk)->space.subscribe(pattern("7:**"), {}, [](const Event&) {});
    time.run_for(10s);
  }
  Verdict set() {
    const auto got = std::make_shared<Verdict>(Verdict::kTimedOut);
    (*desk)->space.set_remote(OwnerId(7), "kitchen.lamp", "on", 5s,
                              [got](const Reply& reply) { *got = reply.verdict; });
    time.run_for(6s);
    return *got;
  }
  void expect_served() {
    EXPECT_NE((*desk)->value(7, "kitchen.lamp"), "absent");
    EXPECT_EQ(set(), Verdict::kApplied);
  }

  VirtualScheduler time;
  support::CollectingLog log;
  BrokerWire broker{time, log};
  TwinWire dds{time};
  std::shared_ptr<GivenRealm> realm =
      std::make_shared<GivenRealm>(std::map<std::string, std::vector<IdRange>, std::less<>>{
          {"attic", {{1, 1}}}, {"hall", {{2, 2}, {7, 7}}}, {"lab", {{3, 3}, {7, 7}}}, {"desk", {{8, 8}}}});
  RealmWire of_attic{broker, "attic", realm}, of_hall{broker, "hall", realm}, of_lab{broker, "lab", realm},
      of_desk{broker, "desk", realm};
  std::array<std::uint32_t, 3> ids{1, 2, 3};
  Island attic, hall, lab;
  std::unique_ptr<Site<Home>> robot;
  std::unique_ptr<Site<>> desk;
  Handle copies;
};

TEST_F(CarriersInARealm, TheLowestWhoMayUseTheIdCarriesAndTheNextTakesOver) {
  expect_served();
  EXPECT_EQ(hall->stand_ins(), 2U) << "of the robot and of its reader";
  EXPECT_EQ(lab->stand_ins() + attic->stand_ins(), 0U);
  EXPECT_TRUE(log.contains("attic may not be 7 at the broker: allow it by `rubicon trust change attic`"));
  hall->kill();
  hall.reset();
  time.run_for(20s + Carrier::kSettle + 2s);
  expect_served();
  EXPECT_EQ(lab->stand_ins(), 2U);
  lab->kill();
  lab.reset();
  time.run_for(2min);
  EXPECT_EQ(attic->stand_ins(), 0U) << "never";
  EXPECT_EQ(set(), Verdict::kNoSuchOwner);
}

TEST_F(CarriersInARealm, WhoMayUseItNoLongerEndsItsStandIn) {
  realm->give("hall", {{2, 2}});
  time.run_for(10s);
  expect_served();
  EXPECT_EQ(hall->stand_ins(), 0U);
  EXPECT_EQ(lab->stand_ins(), 2U);
}

TEST(InARealm, AStandInNeedsThatItsCarrierMayUseTheIdOfItsComponent) {
  for (const std::uint32_t also : {1U, 7U}) {
    VirtualScheduler time;
    support::CollectingLog log;
    BrokerWire wire(time, log);
    const auto realm = std::make_shared<GivenRealm>(
        std::map<std::string, std::vector<IdRange>, std::less<>>{{"hall", {{1, 1}, {also, also}}}, {"desk", {{8, 8}}}});
    const auto carrier = wire.enter("hall", realm), reader = wire.enter("desk", realm);
    time.run_for(1s);
    const auto stand_in = carrier.engine->join_as({OwnerId(7), marked_host("far", OwnerId(1)), {}});
    ASSERT_EQ(stand_in.has_value(), also == 7);
    const auto carried = stand_in ? std::make_unique<TupleSpace>(OwnerId(7), time, **stand_in) : nullptr;
    const Observer desk(*reader.engine, time, 8);
    time.run_for(5s);
    EXPECT_THAT(desk.space.peers(), testing::SizeIs(also == 7 ? 1 : 0));
  }
}

INSTANTIATE_TEST_SUITE_P(Users, AtABroker, testing::Values("hall", "robot"));

}  // namespace
}  // namespace rubicon::tuples::carry
