#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "support/conversation.h"
#include "support/private_network.h"
#include "tuples/dds/rogue.h"

namespace rubicon::ecology {
namespace {

using support::ask;
using support::Process;
using tuples::dds::Rogue;

const std::string kVisitor = RUBICON_BINARY_DIR "/bin/ecology-member";
constexpr std::uint32_t kMemberId = 70000, kRogue = 66666;
/// Without bounds each flood takes at least three times as much.
constexpr long kMaxGrowth = 8L * 1024;

/// A component in a process of its own, and a sender that floods it over DDS.
class AFlood : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    member_ = std::make_unique<Process>(std::vector<std::string>{kVisitor, std::to_string(kMemberId), "dds"});
    ASSERT_EQ(ask(*member_, "set a 1")["ok"], true);
    rogue_ = std::make_unique<Rogue>(kRogue);
    incarnation_ = rogue_->incarnation_of(kMemberId);
    ASSERT_NE(incarnation_, 0U);
    before_ = member_->resident_kilobytes();
  }
  /// Checked again after everything was processed.
  void expect_no_growth() {
    for (int i = 0; i < 20; ++i) ASSERT_EQ(ask(*member_, "set a 1")["ok"], true);
    EXPECT_LT(member_->resident_kilobytes() - before_, kMaxGrowth);
  }

  support::PrivateNetwork alone_;
  std::unique_ptr<Process> member_;
  std::unique_ptr<Rogue> rogue_;
  std::uint64_t incarnation_ = 0;
  long before_ = 0;
};

TEST_F(AFlood, OfStartsOfOneComponentTakesNoMemory) {
  for (std::uint64_t i = 1; i <= 40'000; ++i) rogue_->show(kRogue, rogue_->incarnation() + i);
  expect_no_growth();
}

TEST_F(AFlood, OfFramesBeforeAnyPresenceTakesNoMemory) {
  for (int i = 0; i < 300'000; ++i) rogue_->frame(kRogue, rogue_->incarnation() + 1, kMemberId, incarnation_, {});
  expect_no_growth();
}

}  // namespace
}  // namespace rubicon::ecology
