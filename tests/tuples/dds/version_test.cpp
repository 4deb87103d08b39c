#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"
#include "tuples/dds/rogue.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// In the domain of this process's ecologies, whose tag it has so.
TEST(OtherVersions, AComponentOfAnotherVersionIsNotTalkedTo) {
  VirtualScheduler time;
  TestEcology ecology(time);
  Component island(ecology, time, 1);
  const dds::Rogue newer(2, 99);
  for (int i = 0; i < 20; ++i) time.run_for(10ms);
  EXPECT_THAT(island.space.peers(), IsEmpty());
  const dds::Rogue equal(3, dds::kProtocolVersion);
  for (int i = 0; i < 100 && island.space.peers().empty(); ++i) time.run_for(10ms);
  EXPECT_THAT(island.space.peers(), ElementsAre(OwnerId(3)));
}

}  // namespace
}  // namespace rubicon::tuples
