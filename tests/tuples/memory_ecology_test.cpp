#include <gtest/gtest.h>

#include "tuples/component.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::tuples {
namespace {

TEST(MemoryEcology, RefusesASecondComponentWithTheSameId) {
  VirtualScheduler scheduler;
  MemoryEcology ecology(scheduler);
  Component first(ecology, scheduler, 1);
  const auto second = ecology.join(OwnerId(1));
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code, ErrorCode::kDuplicate);
}

TEST(MemoryEcology, CarriesAValueToADistantSubscriber) {
  VirtualScheduler scheduler;
  MemoryEcology ecology(scheduler);
  Component island(ecology, scheduler, 1), robot(ecology, scheduler, 70000);
  std::string seen;
  const auto handle = robot.space.subscribe(*Pattern::parse("1:a.*"), {}, [&](const Event& e) {
    seen = std::string(e.tuple.key) + "=" + std::string(e.tuple.value);
  });
  ASSERT_TRUE(island.space.set("a.b", "21.5").has_value());
  scheduler.run_ready();
  EXPECT_EQ(seen, "a.b=21.5");
}

TEST(MemoryEcology, CarriesARemoteSetAndItsReply) {
  VirtualScheduler scheduler;
  MemoryEcology ecology(scheduler);
  Component island(ecology, scheduler, 1), robot(ecology, scheduler, 70000);
  const auto policy =
      island.space.add_policy(*Pattern::parse("GATEWAY"), [](const RemoteSet&) { return SetDecision::consumed(); });
  std::vector<Verdict> verdicts;
  robot.space.set_remote(OwnerId(1), "GATEWAY", "x", {}, [&](const Reply& r) { verdicts.push_back(r.verdict); });
  robot.space.set_remote(OwnerId(2), "GATEWAY", "x", {}, [&](const Reply& r) { verdicts.push_back(r.verdict); });
  scheduler.run_ready();
  EXPECT_EQ(verdicts, (std::vector{Verdict::kNoSuchOwner, Verdict::kApplied}));
}

}  // namespace
}  // namespace rubicon::tuples
