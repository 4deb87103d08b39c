#include "tuples/dds/refusals.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"

namespace rubicon::tuples::dds {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

struct RefusalsTest : testing::Test {
  base::VirtualScheduler scheduler;
  support::CollectingLog log;
  std::unique_ptr<Refusals> refusals = std::make_unique<Refusals>(
      scheduler, [this](auto call) { scheduler.post(std::move(call)); }, log);

  void take(const std::string& name, const std::string& reason) {
    refusals->take({}, name, reason);
    scheduler.run_ready();
  }
};

TEST_F(RefusalsTest, AreNamedOnceAMinuteThoughTheyTryEachSecond) {
  for (int i = 0; i < 59; ++i) {
    take("desk", "its certificate is revoked");
    scheduler.run_for(1s);
  }
  EXPECT_THAT(log.lines, ElementsAre("dds: 'desk' was refused: its certificate is revoked"));
  scheduler.run_for(1s);
  take("desk", "its certificate is revoked");
  EXPECT_THAT(log.lines, SizeIs(2));
}

TEST_F(RefusalsTest, SayThatACertificateIsOfAnotherRealm) {
  take("desk", "Certificate not valid: error: unable to get local issuer certificate");
  EXPECT_TRUE(log.contains("'desk' was refused, its certificate is of another realm: Certificate not valid"));
  take("", "no reason was given");
  EXPECT_TRUE(log.contains("a process was refused: no reason was given"));
}

TEST_F(RefusalsTest, DoNotFillTheLogWithNames) {
  for (int i = 0; i < 500; ++i) take(std::to_string(i), "no");
  EXPECT_THAT(log.lines, SizeIs(Refusals::kMaxLines + 1));
  EXPECT_TRUE(log.contains("more processes are refused"));
  scheduler.run_for(1min);
  take("again", "no");
  EXPECT_TRUE(log.contains("'again' was refused"));
}

TEST_F(RefusalsTest, DoNotFillTheLoopNorOutliveTheirOwner) {
  for (int i = 0; i < 500; ++i) refusals->take({}, std::to_string(i), "no");
  refusals.reset();
  scheduler.run_ready();
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(RefusalsTest, CountEachPeerOnceThoughItTriesEachSecond) {
  const auto peer = [](std::uint8_t number, std::uint8_t more = 0) { return GuidPrefix{1, number, more}; };
  for (int i = 0; i < 60; ++i) {
    refusals->take(peer(1), "desk", "no");
    refusals->take(peer(2), "desk", "another process of the same name");
    refusals->take({}, "", "it is not known which process that was");
  }
  EXPECT_EQ(refusals->peers(), 2U);
  for (std::size_t i = 0; i < Refusals::kMaxKnown; ++i)
    refusals->take(peer(static_cast<std::uint8_t>(i % 256), static_cast<std::uint8_t>(1 + i / 256)), "", "no");
  EXPECT_EQ(refusals->peers(), 2 + Refusals::kMaxKnown);
  refusals->take(peer(1), "desk", "forgotten among so many");
  EXPECT_EQ(refusals->peers(), 3 + Refusals::kMaxKnown);
}

}  // namespace
}  // namespace rubicon::tuples::dds
