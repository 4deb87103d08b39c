#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/rogue.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// In the domain of this process's ecologies, whose tag it has so.
TEST(OtherVersions, AComponentOfAnotherVersionIsNotTalkedTo) {
  VirtualScheduler time;
  dds::DdsTestEcology ecology(time);
  Component island(ecology, time, 1);
  const dds::Rogue newer(2, 99);
  const auto is_named = [&] {
    return ecology.log().contains(
        "component 2 has version 99 of the protocol, this program version 3: ignored; it is "
        "of a newer release");
  };
  for (int i = 0; i < 200 && !is_named(); ++i) time.run_for(10ms);
  EXPECT_TRUE(is_named());
  EXPECT_THAT(island.space.peers(), IsEmpty());
  const dds::Rogue equal(3, dds::kProtocolVersion);
  for (int i = 0; i < 100 && island.space.peers().empty(); ++i) time.run_for(10ms);
  EXPECT_THAT(island.space.peers(), ElementsAre(OwnerId(3)));
}

/// Version 1 has its presence in the default partition, and reads there only.
TEST(OtherVersions, ThisVersionAndTheFirstOneNoticeEachOther) {
  VirtualScheduler time;
  dds::DdsTestEcology ecology(time);
  Component island(ecology, time, 1);
  dds::Rogue first(2, 1);
  const auto says_so = [&] {
    return ecology.log().contains("component 2 has version 1 of the protocol, this program version 3: ignored");
  };
  for (int i = 0; i < 200 && !says_so(); ++i) time.run_for(10ms);
  EXPECT_TRUE(says_so());
  EXPECT_EQ(first.shown_by(1, "").version, 3U);
  const auto seen = ecology.component_starts();
  EXPECT_TRUE(std::any_of(seen.begin(), seen.end(), [](const auto& one) { return one.present && one.version == 1; }));
}

/// An island (1) and a component (2) of a newer version.
struct ANewerVersion : testing::Test {
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) time.run_for(10ms);
    return done();
  }
  bool is_present(std::uint32_t id) const {
    const auto all = ecology.component_starts();
    return std::any_of(all.begin(), all.end(), [id](const auto& one) { return one.id == OwnerId(id) && one.present; });
  }
  void SetUp() override {
    ASSERT_TRUE(until([&] { return is_present(2); }));
  }

  VirtualScheduler time;
  dds::DdsTestEcology ecology{time};
  Component island{ecology, time, 1};
  std::unique_ptr<dds::Rogue> newer = std::make_unique<dds::Rogue>(2, 99);
};

TEST_F(ANewerVersion, IsNotPresentAnyMoreWhenItsPublicationIsGone) {
  dds::Rogue other(3, 99);
  other.show(2, newer->incarnation());
  other.arrive();
  ASSERT_TRUE(until([&] { return is_present(3); }));
  for (int i = 0; i < 50; ++i) time.run_for(1ms);
  newer.reset();
  EXPECT_TRUE(until([&] { return !is_present(2); })) << "whoever shows it too";
  EXPECT_TRUE(is_present(3));
}

/// It is not met again: it is in this process, and its participant goes with the domain.
TEST_F(ANewerVersion, IsNotPresentAnyMoreWhenTheDomainIsLeft) {
  ecology.enter_again();
  EXPECT_TRUE(until([&] { return !is_present(2); }));
}

TEST(ExpectedComponents, AreThoseWhosePresenceHasNotArrived) {
  VirtualScheduler time;
  dds::DdsTestEcology ecology(time);
  Component island(ecology, time, 1);
  const auto in_the_end = [&](bool expected) {
    for (int i = 0; i < 1000 && ecology.expects_components() != expected; ++i) time.run_for(10ms);
    return ecology.expects_components() == expected;
  };
  const dds::Rogue other(2);
  for (int i = 0; i < 1000 && island.space.peers().empty(); ++i) time.run_for(10ms);
  EXPECT_TRUE(in_the_end(false));
  auto silent = std::make_unique<dds::Entity>(other.silent_writer());
  EXPECT_TRUE(in_the_end(true)) << "it is matched, and has said nothing";
  silent.reset();
  EXPECT_TRUE(in_the_end(false));
}

}  // namespace
}  // namespace rubicon::tuples
