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
    refusals->take({{}, name, false, reason});
    scheduler.run_ready();
  }
  void take_member(const std::string& name, const std::string& reason) {
    refusals->take({{}, name, true, reason});
    scheduler.run_ready();
  }
};

TEST_F(RefusalsTest, AreNamedOnceAMinuteThoughTheyTryEachSecond) {
  for (int i = 0; i < 59; ++i) {
    take_member("desk", "its certificate is revoked");
    scheduler.run_for(1s);
  }
  EXPECT_THAT(log.lines, ElementsAre("dds: 'desk' was refused: its certificate is revoked"));
  scheduler.run_for(1s);
  take_member("desk", "its certificate is revoked");
  EXPECT_THAT(log.lines, SizeIs(2));
}

TEST_F(RefusalsTest, SayThatACertificateIsOfAnotherRealmAndItsNameAClaim) {
  take("desk", "Certificate not valid: error: unable to get local issuer certificate");
  take("", "no reason was given");
  EXPECT_THAT(log.lines,
              ElementsAre("dds: a process that calls itself 'desk' was refused, its certificate is of another realm: "
                          "Certificate not valid: error: unable to get local issuer certificate",
                          "dds: a process was refused: no reason was given"));
}

TEST_F(RefusalsTest, SayOfAMemberThatItsPermissionsAreNotOfTheRealm) {
  take_member("mallory", "PKCS7_verify: unable to get local issuer certificate");
  EXPECT_THAT(log.lines, ElementsAre("dds: 'mallory' was refused, its permissions are not signed by this realm: "
                                     "PKCS7_verify: unable to get local issuer certificate"));
}

TEST_F(RefusalsTest, DoNotFillTheLogWithNames) {
  for (int i = 0; i < 500; ++i) take(std::to_string(i), "no");
  EXPECT_THAT(log.lines, SizeIs(Refusals::kMaxLines + 1));
  EXPECT_TRUE(log.contains("more processes are refused"));
  scheduler.run_for(1min);
  take("again", "no");
  EXPECT_TRUE(log.contains("'again' was refused"));
}

TEST_F(RefusalsTest, NameAMemberThoughManyStrangersClaimNamesAndItsOwn) {
  take("mallory", "no");
  for (int i = 0; i < 500; ++i) take(std::to_string(i), "no");
  const auto before = log.lines.size();
  take_member("mallory", "its GUID belongs to the certificate of another");
  ASSERT_THAT(log.lines, SizeIs(before + 1));
  EXPECT_EQ(log.lines.back(), "dds: 'mallory' was refused: its GUID belongs to the certificate of another");
  for (int i = 0; i < 500; ++i) refusals->take({{}, std::to_string(i), false, "no"});
  take_member("desk", "its certificate is revoked");
  EXPECT_EQ(log.lines.back(), "dds: 'desk' was refused: its certificate is revoked") << "others fill the loop";
}

TEST_F(RefusalsTest, DoNotFillTheLogWithMembers) {
  for (int i = 0; i < 500; ++i) take_member(std::to_string(i), "no");
  EXPECT_THAT(log.lines, SizeIs(Refusals::kMaxLines + 1));
  EXPECT_TRUE(log.contains("more members are refused"));
}

TEST_F(RefusalsTest, DoNotFillTheLoopNorOutliveTheirOwner) {
  for (int i = 0; i < 500; ++i) refusals->take({{}, std::to_string(i), false, "no"});
  refusals.reset();
  scheduler.run_ready();
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(RefusalsTest, CountEachPeerOnceThoughItTriesEachSecond) {
  const auto peer = [](std::uint8_t number, std::uint8_t more = 0) { return GuidPrefix{1, number, more}; };
  for (int i = 0; i < 60; ++i) {
    refusals->take({peer(1), "desk", true, "no"});
    refusals->take({peer(2), "desk", true, "another process of the same name"});
    refusals->take({{}, "", false, "it is not known which process that was"});
  }
  EXPECT_EQ(refusals->peers(), 2U);
  for (std::size_t i = 0; i < Refusals::kMaxKnown; ++i)
    refusals->take({peer(static_cast<std::uint8_t>(i % 256), static_cast<std::uint8_t>(1 + i / 256)), "", false, "no"});
  EXPECT_EQ(refusals->peers(), 2 + Refusals::kMaxKnown);
  refusals->take({peer(1), "desk", true, "forgotten among so many"});
  EXPECT_EQ(refusals->peers(), 3 + Refusals::kMaxKnown);
}

}  // namespace
}  // namespace rubicon::tuples::dds
