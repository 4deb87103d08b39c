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

INSTANTIATE_TEST_SUITE_P(Users, AtABroker, testing::Values("hall", "robot"));

}  // namespace
}  // namespace rubicon::tuples::carry
