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
  Handle watch(std::function<void()>) override { return {}; }

 private:
  std::map<std::string, std::shared_ptr<const Member>, std::less<>> members_;
  std::string document_ = "given";
};

TEST(InARealm, AStandInNeedsThatItsCarrierMayUseTheIdOfItsComponent) {
  for (const std::uint32_t also : {1U, 7U}) {
    VirtualScheduler time;
    support::CollectingLog log;
    BrokerWire wire(time, log);
    const auto realm = std::make_shared<GivenRealm>(
        std::map<std::string, std::vector<IdRange>, std::less<>>{{"hall", {{1, 1}, {also, also}}}, {"desk", {{8, 8}}}});
    const auto carrier = wire.enter("hall", realm), reader = wire.enter("desk", realm);
    const auto stand_in = std::move(*carrier.engine->join_as({OwnerId(7), marked_host("far", OwnerId(1)), {}}));
    const TupleSpace carried(OwnerId(7), time, *stand_in);
    const Observer desk(*reader.engine, time, 8);
    time.run_for(5s);
    EXPECT_THAT(desk.space.peers(), testing::SizeIs(also == 7 ? 1 : 0));
    EXPECT_EQ(log.contains("presence of component 7, an id of another user"), also != 7);
  }
}

INSTANTIATE_TEST_SUITE_P(Users, AtABroker, testing::Values("hall", "robot"));

}  // namespace
}  // namespace rubicon::tuples::carry
